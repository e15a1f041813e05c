"""Ratios of processor times, which a busy machine upsets little."""

import time
from collections.abc import Callable


def ratio(ours: Callable[[], object], peer: Callable[[], object], rounds: int = 15) -> float:
    """Return the processor time of `ours` over that of `peer`: the quickest of each, taken in turns."""
    best = {ours: float("inf"), peer: float("inf")}
    for _ in range(rounds):
        for run in best:
            start = time.process_time()
            run()
            best[run] = min(best[run], time.process_time() - start)
    return best[ours] / best[peer]
