"""How long work says how far it is; it may be stopped from inside the callback."""

from collections.abc import Callable

Progress = Callable[[float, str], None]


def silent(fraction: float, message: str) -> None:
    """Say nothing: the default of every `progress` parameter."""
