"""Progress callbacks of long computations, which may also cancel them."""

from collections.abc import Callable

Progress = Callable[[float, str], None]


class Pulse:
    """Progress callback that can repeat its latest report, as a sign of life during long steps.

    A cancelled computation stops at the next report.
    """

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._last = (0.0, "")

    def __call__(self, fraction: float, message: str) -> None:
        """Report the progress: a fraction, 0 to 1, and a message."""
        self._last = (fraction, message)
        self._progress(fraction, message)

    def beat(self) -> None:
        """Repeat the latest report."""
        if self._last[1]:
            self._progress(*self._last)


def silent(fraction: float, message: str) -> None:
    """Report nothing: the default of every `progress` parameter."""


def part(progress: Progress, low: float, high: float) -> Progress:
    """Return the callback for a part of the work, from the fraction `low` to `high` of the whole."""
    return lambda fraction, message: progress(low + (high - low) * fraction, message)
