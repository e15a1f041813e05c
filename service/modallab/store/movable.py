"""What of an owner can be stored elsewhere."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from modallab.store.base import Entry


@dataclass(frozen=True)
class Movable:
    """What of an owner can be stored elsewhere, and what cannot."""

    entries: tuple[Entry, ...]
    """Each after those that it was made from."""
    left_out: tuple[str, ...]
    """Ids of measurements of assignments, and of what was made from these or from others' things."""


@dataclass(frozen=True)
class StoredParts:
    """A thing as it lies in the store."""

    body: Any
    """JSON of `codec`."""
    request: Mapping[str, Any] | None
    """Body of the request that described it; None: it was not described by one."""
    arrays: bytes
    """npz file; empty without arrays."""


class Projects(Protocol):
    """What an owner has, to be stored elsewhere."""

    def movable(self, *, owner: str, label: str | None = None) -> Movable:
        """Return what of an owner's, with one of the labels and what it was made from, can be exported."""
        ...

    def parts(self, id: str) -> StoredParts:
        """Return a thing as it lies in the store; `InvalidInputError` if it has gone."""
        ...
