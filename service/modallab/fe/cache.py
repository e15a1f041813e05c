"""What was worked out of a system before, kept for when it is asked for again."""

from collections.abc import Callable
from typing import TypeVar

from modallab.fe.settings import CACHE

T = TypeVar("T")


def cached(
    shared: dict[str, object], name: str, key: object, make: Callable[[], T], most: int = CACHE.variants
) -> T:
    """Return what was made for a key before, or else make it; the latest few of a name are kept."""
    variants: dict[object, T] = shared.setdefault(name, {})  # type: ignore[assignment]
    found = variants.pop(key) if key in variants else make()
    variants[key] = found  # behind all others: the first one is what was not asked for longest
    if len(variants) > most:
        del variants[next(iter(variants))]
    return found
