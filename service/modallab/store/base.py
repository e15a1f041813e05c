"""What a store offers: shelves of immutable things, each under an opaque id."""

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from modallab.assignments.terms import AssignmentTerms
from modallab.core.errors import ModalLabError
from modallab.core.place import EffectSpec
from modallab.store.viewer import Viewer

if TYPE_CHECKING:
    from modallab.store.exported import Projects

T = TypeVar("T")


class InUseError(ModalLabError):
    """Something else that is stored was made from this."""

    code = "in_use"


class InTrashError(ModalLabError):
    """What it was made from is in the trash."""

    code = "in_trash"


class ForbiddenError(ModalLabError):
    """The key does not allow this."""

    code = "forbidden"


class UnauthorisedError(ModalLabError):
    """No key was sent, or one that is not valid."""

    code = "unauthorized"  # as HTTP spells it


class StoredDataError(ModalLabError):
    """What is stored cannot be read back: damaged, or written by another version."""

    code = "stored_data"


class MissingFileError(StoredDataError):
    """An array file is gone: lost, or just removed with the thing that it belongs to."""


@dataclass(frozen=True)
class Entry:
    """What is known of a stored thing without reading it: enough to make it again."""

    id: str
    kind: str
    owner: str
    created: str  # ISO 8601, UTC
    version: str  # of modallab that made it
    inputs: Mapping[str, str] = field(default_factory=dict)  # what it was made from: role -> id
    seed: int | None = None
    name: str = ""
    labels: Sequence[str] = ()
    comment: str = ""


@dataclass(frozen=True)
class Discarded:
    """A thing in the trash."""

    entry: Entry
    removed: str  # ISO 8601, UTC
    until: str  # ISO 8601, UTC, before which it can be restored


@dataclass(frozen=True)
class Description:
    """What an owner says of a stored thing; None: as it was."""

    name: str | None = None
    labels: Sequence[str] | None = None
    comment: str | None = None


@dataclass(frozen=True)
class Truth:
    """Structure and hidden effects of a simulated measurement, for its owner only."""

    structure_id: str
    """Structure that was tested."""
    effects: tuple[EffectSpec, ...]
    """Effects beside those of the structure and the rig."""


@dataclass(frozen=True)
class Trial:
    """A measurement of an assignment."""

    assignment_id: str
    student: str
    """Id of the student's key."""
    number: int
    """Number of the student's measurement, from 1 on."""


class Shelf(Protocol[T]):
    """Things of one kind. Nothing but its description is ever changed in place."""

    def add(
        self,
        thing: T,
        *,
        owner: str,
        inputs: Mapping[str, str] | None = None,
        seed: int | None = None,
        id: str | None = None,
        request: Mapping[str, Any] | None = None,
        version: str = ...,
    ) -> str:
        """Store a thing and return its id; under an `id` that is taken, nothing happens.

        Work that may run twice passes the same `id` both times and stores once.

        Parameters
        ----------
        request
            Body of the request that described the thing; None: it was not described by one.
        version
            Of modallab that made it; by default this one.
        """
        ...

    def request(self, id: str) -> Mapping[str, Any] | None:
        """Return the body of the request that described a thing to who may manage it, None if none did.

        Raises
        ------
        NotFoundError
            If the thing is not there.
        ForbiddenError
            If it is only shared with the viewer: a description tells what a class may have to find.
        """
        ...

    def get(self, id: str) -> T:
        """Return a thing; `NotFoundError` if there is none."""
        ...

    def entry(self, id: str) -> Entry:
        """Return what is known of a thing; `NotFoundError` if there is none."""
        ...

    def list(
        self,
        *,
        owner: str | None = None,
        name: str | None = None,
        label: str | None = None,
        limit: int,
        cursor: str | None = None,
    ) -> list[Entry]:
        """Return the newest entries, those older than `cursor`.

        Parameters
        ----------
        owner, label
            Of the entries; None: any.
        name
            Part of their names, in capitals or not; None: any name.
        """
        ...

    def describe(self, id: str, description: Description) -> None:
        """Change what is said of a thing."""
        ...

    def hand_over(self, id: str, *, owner: str, created: str) -> None:
        """Give a thing that nobody has, stored for `UNPUBLISHED`, to its owner.

        Parameters
        ----------
        created
            ISO 8601, UTC, time from which it is there.
        """
        ...

    def npz(self, id: str) -> bytes:
        """Return a thing's arrays as an uncompressed npz file, as they lie in the store."""
        ...

    def discard(self, id: str) -> None:
        """Move a thing to the trash; `InUseError` if another that is there was made from it."""
        ...

    def remove(self, id: str) -> None:
        """Forget a thing at once and for good; `InUseError` if another was made from it."""
        ...

    def check(self, id: str) -> None:
        """Raise `NotFoundError` unless the thing is there."""
        ...

    def holds(self, id: str) -> bool:
        """Tell whether the thing is there."""
        ...


class TruthShelf(Protocol):
    """How measurements were made."""

    def add(self, truth: Truth, *, measurement_id: str, owner: str) -> None:
        """Store how a measurement was made, once."""
        ...

    def get(self, measurement_id: str, *, owner: str) -> Truth:
        """Return how a measurement was made, to its owner; to others it is not found."""
        ...

    def holds(self, measurement_id: str) -> bool:
        """Tell whether it is known how a measurement was made: it was made here."""
        ...


class TrialShelf(Protocol):
    """Which measurements belong to which assignment."""

    def fulfil(self, trial: Trial, measurement_id: str) -> None:
        """Enter the measurement of a trial."""
        ...

    def assignments_of(self, measurement_ids: Sequence[str]) -> Mapping[str, AssignmentTerms]:
        """Return the assignments of those measurements that belong to one."""
        ...

    def of_class(self, class_id: str) -> Mapping[str, AssignmentTerms]:
        """Return the assignments of all measurements of a class by the measurements' ids."""
        ...


class Trash(Protocol):
    """What was deleted and can be restored."""

    def list(self, *, owner: str, limit: int, cursor: str | None = None) -> list[Discarded]:
        """Return what an owner has in the trash, last deleted first, what was deleted before `cursor`."""
        ...

    def restore(self, id: str) -> Entry:
        """Return the entry of a thing that is taken out of the trash.

        `InTrashError` if something that it was made from is in the trash, too.
        """
        ...

    def remove(self, id: str) -> None:
        """Remove a thing in the trash for good; `InUseError` if another one there was made from it."""
        ...


class Store(Protocol):
    """Everything that is kept."""

    # Any: the shelf of a kind holds one domain type, which `codec.CODECS` names.
    structures: Shelf[Any]
    rigs: Shelf[Any]
    measurements: Shelf[Any]
    modal_models: Shelf[Any]
    correlations: Shelf[Any]
    updates: Shelf[Any]
    studies: Shelf[Any]
    diagnoses: Shelf[Any]
    truths: TruthShelf
    trials: TrialShelf
    trash: Trash
    projects: "Projects"

    def as_seen_by(self, viewer: Viewer) -> "Store":
        """Return the store in which only what is there for the viewer exists."""
        ...

    @property
    def unrestricted(self) -> "Store":
        """The store as the service itself sees it."""
        ...

    def weight(self, ids: Sequence[str], array_bytes: float, *, origins: bool) -> float:
        """Return the bytes of things, with `origins` of what they were made from, too; arrays count less."""
        ...

    def together(self) -> "AbstractContextManager[Store]":
        """Return a store whose additions are seen all at once when the block ends, or never."""
        ...
