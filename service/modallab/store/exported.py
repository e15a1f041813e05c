"""Contents of a project: objects of an owner that an export writes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from modallab.store.base import Entry


@dataclass(frozen=True)
class ProjectContents:
    """Objects of an owner that an export writes, and those that it leaves out."""

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
    """Projects of all owners."""

    def contents(self, *, owner: str, label: str | None = None) -> ProjectContents:
        """Return the objects of an owner that an export writes: all, or those with a label and origins."""
        ...

    def parts(self, id: str) -> StoredParts:
        """Return a thing as it lies in the store; `InvalidInputError` if it has gone."""
        ...
