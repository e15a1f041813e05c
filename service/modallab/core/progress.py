"""How long work says how far it is; it may be stopped from inside the callback."""

from collections.abc import Callable

Progress = Callable[[float, str], None]


class Pulse:
    """A progress callback that says again what it said last, so that long steps are seen to be alive.

    Work that nobody wants any more is stopped between two beats.
    """

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._last = (0.0, "")

    def __call__(self, fraction: float, message: str) -> None:
        """Say how far the work is."""
        self._last = (fraction, message)
        self._progress(fraction, message)

    def beat(self) -> None:
        """Say it again."""
        if self._last[1]:
            self._progress(*self._last)


def silent(fraction: float, message: str) -> None:
    """Say nothing: the default of every `progress` parameter."""


def part(progress: Progress, low: float, high: float) -> Progress:
    """Return the callback of a part of the work, from `low` to `high` of the whole."""
    return lambda fraction, message: progress(low + (high - low) * fraction, message)
