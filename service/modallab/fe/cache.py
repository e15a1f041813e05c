"""Typed least-recently-used cache of results that depend on a system's matrices alone."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class CacheSlot(Generic[T]):
    """One kind of cached result: the type of its values, its name and how many of them are stored."""

    name: str
    capacity: int = 1


class Cache:
    """Results by slot and key; above a slot's capacity the least recently used result is dropped."""

    def __init__(self) -> None:
        self._entries: dict[CacheSlot[Any], dict[object, Any]] = {}

    def entries(self, slot: CacheSlot[T]) -> dict[Any, T]:
        """Return all results of a slot by key, the most recently used last."""
        return self._entries.get(slot, {})

    def get(self, slot: CacheSlot[T], key: object = None) -> T | None:
        """Return the result of a key, None if there is none; its place in the order of use stays."""
        return self.entries(slot).get(key)

    def put(self, slot: CacheSlot[T], value: T, key: object = None, *, capacity: int | None = None) -> T:
        """Store the result of a key and return it.

        Parameters
        ----------
        capacity
            Results stored at most, in place of the slot's own number.
        """
        entries = self._entries.setdefault(slot, {})
        entries.pop(key, None)
        entries[key] = value  # dictionaries keep the order of insertion: the first is the least recently used
        if len(entries) > (slot.capacity if capacity is None else capacity):
            del entries[next(iter(entries))]
        return value

    def compute(
        self, slot: CacheSlot[T], key: object, make: Callable[[], T], *, capacity: int | None = None
    ) -> T:
        """Return the cached result of a key, or make and store it; see `put`."""
        entries = self._entries.setdefault(slot, {})
        value: T = entries[key] if key in entries else make()
        return self.put(slot, value, key, capacity=capacity)
