"""Ratios of processor times, which a busy machine upsets little."""

import statistics
import time
from collections.abc import Callable


def ratio(ours: Callable[[], object], peer: Callable[[], object], rounds: int = 15) -> float:
    """Return the processor time of `ours` over that of `peer`, the median of rounds with one after the other.

    Not the quickest of each: a processor that is now fast, now slow may be fast for one of them only.
    """
    return statistics.median(_seconds(ours) / _seconds(peer) for _ in range(rounds))


def _seconds(run: Callable[[], object]) -> float:
    begun = time.process_time()
    run()
    return time.process_time() - begun
