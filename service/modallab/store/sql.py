"""Store of objects in an SQL database and in array files."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import fields
from datetime import UTC, datetime
from typing import Any, Generic, TypeVar

import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError

import modallab
from modallab.core.errors import NotFoundError
from modallab.store.arrays import ArrayFiles
from modallab.store.base import Description, Entry, ForbiddenError, InUseError, MissingFileError
from modallab.store.codec import CODECS, Codec
from modallab.store.npz import pack, unpack
from modallab.store.projects import SqlProjects
from modallab.store.rows import insert_once, new_id
from modallab.store.tables import LINKS, THINGS
from modallab.store.trash import SqlTrash, absence, discard, take_out
from modallab.store.trials import SqlTrials
from modallab.store.truths import SqlTruths
from modallab.store.uses import lock_untrashed
from modallab.store.viewer import EVERYONE, UNPUBLISHED, Viewer, manageable, readable
from modallab.store.weights import weight_of

T = TypeVar("T")
Connect = Callable[[], AbstractContextManager[sa.Connection]]

_LONGEST_NAME = 100
_ENTRY_FIELDS = tuple(field.name for field in fields(Entry))
_ENTRY = [THINGS.c[name] for name in _ENTRY_FIELDS]


class SqlShelf(Generic[T]):
    """Things of one kind: metadata and body in a row, arrays in a file."""

    def __init__(
        self, kind: str, codec: Codec[T], connect: Connect, files: ArrayFiles, viewer: Viewer = EVERYONE
    ) -> None:
        self._kind, self._codec, self._connect, self._files = kind, codec, connect, files
        self._viewer = viewer

    def add(
        self,
        thing: T,
        *,
        owner: str,
        inputs: Mapping[str, str] | None = None,
        seed: int | None = None,
        id: str | None = None,
        request: Mapping[str, Any] | None = None,
        version: str = modallab.__version__,
    ) -> str:
        """Store a thing and return its id; under an `id` that is taken, nothing happens."""
        own_id = id or new_id()
        if id is not None and self.holds(id):
            return id
        body, arrays = self._codec.take_apart(thing)
        packed = pack(arrays) if arrays else b""
        row = {
            "id": own_id,
            "kind": self._kind,
            "owner": owner,
            "created": datetime.now(UTC).isoformat(timespec="microseconds"),
            "version": version,
            "inputs": dict(inputs or {}),
            "seed": seed,
            "body": body,
            "request": request,
            "arrays_hash": self._files.put(own_id, packed) if arrays else None,
            "size": len(json.dumps(body)) + len(json.dumps(request)) * bool(request) + len(packed),
            "name": getattr(thing, "name", "")[
                :_LONGEST_NAME
            ],  # a structure's own, until its owner gives another
        }
        with self._connect() as connection:
            is_new = insert_once(connection, THINGS, row)
            self._check_origins(connection, set(row["inputs"].values()))
            if is_new:
                for target in sorted(set(row["inputs"].values())):
                    connection.execute(LINKS.insert().values(source=own_id, target=target))
            else:
                take_out(connection, self._kind, own_id, owner)
        return own_id

    def _check_origins(self, connection: sa.Connection, ids: set[str]) -> None:
        if not lock_untrashed(connection, ids):
            raise NotFoundError(
                f"what the {self._kind} was made from is no longer stored", value=", ".join(sorted(ids))
            )

    def _row(self, id: str, *columns: sa.Column[Any]) -> sa.Row[Any]:
        query = sa.select(*columns).where(THINGS.c.id == id, THINGS.c.kind == self._kind)
        with self._connect() as connection:
            row = connection.execute(query.where(readable(self._viewer))).first()
            if row is None:
                raise absence(connection, self._kind, id, self._viewer)
        return row

    def get(self, id: str) -> T:
        """Return a thing."""
        row = self._row(id, THINGS.c.body, THINGS.c.arrays_hash)
        arrays = unpack(self._array_file(id, row.arrays_hash)) if row.arrays_hash else {}
        return self._codec.put_together(row.body, arrays)

    def request(self, id: str) -> Mapping[str, Any] | None:
        """Return the body of the request that described a thing, to who may manage it."""
        self.check(id)
        query = sa.select(THINGS.c.request).where(THINGS.c.id == id, manageable(THINGS.c.owner, self._viewer))
        with self._connect() as connection:
            row = connection.execute(query).first()
        if row is None:
            raise ForbiddenError(f"this {self._kind} is shared with your class, its description is not")
        described: Mapping[str, Any] | None = row.request
        return described

    def entry(self, id: str) -> Entry:
        """Return the entry of a thing."""
        return Entry(**self._row(id, *_ENTRY)._mapping)

    def list(
        self,
        *,
        owner: str | None = None,
        name: str | None = None,
        label: str | None = None,
        limit: int,
        cursor: str | None = None,
    ) -> list[Entry]:
        """Return the newest entries of an owner, a name and a label, those older than `cursor`."""
        age = sa.tuple_(THINGS.c.created, THINGS.c.id)
        query = sa.select(*_ENTRY).where(THINGS.c.kind == self._kind, readable(self._viewer))
        if owner is not None:
            query = query.where(THINGS.c.owner == owner)
        if name is not None:
            query = query.where(THINGS.c.name.icontains(name, autoescape=True))
        if label is not None:
            query = query.where(_has_label(label))
        if cursor is not None:
            query = query.where(age < sa.tuple_(*self._row(cursor, THINGS.c.created, THINGS.c.id)))
        query = query.order_by(THINGS.c.created.desc(), THINGS.c.id.desc()).limit(limit)
        with self._connect() as connection:
            return [Entry(**row._mapping) for row in connection.execute(query)]

    def describe(self, id: str, description: Description) -> None:
        """Change what is said of a thing."""
        self.check(id)
        values: dict[str, Any] = {"id": id}  # an update sets at least one column
        values |= {name: value for name, value in vars(description).items() if value is not None}
        condition = (THINGS.c.id == id) & manageable(THINGS.c.owner, self._viewer)
        change = THINGS.update().where(condition).values(**values)
        with self._connect() as connection:
            if connection.execute(change.returning(THINGS.c.id)).first() is None:
                raise self._shared()

    def hand_over(self, id: str, *, owner: str, created: str) -> None:
        """Give a thing that nobody has to its owner; nothing happens if somebody has it."""
        change = THINGS.update().where(THINGS.c.id == id, THINGS.c.owner == UNPUBLISHED)
        with self._connect() as connection:
            connection.execute(change.values(owner=owner, created=created))

    def _shared(self) -> ForbiddenError:
        return ForbiddenError(
            f"this {self._kind} is shared with your class, and not yours to change or remove"
        )

    def npz(self, id: str) -> bytes:
        """Return a thing's arrays as they lie in the store."""
        digest = self._row(id, THINGS.c.arrays_hash).arrays_hash
        return self._array_file(id, digest) if digest else pack({})

    def _array_file(self, id: str, digest: str) -> bytes:
        try:
            return self._files.get(id, digest)
        except MissingFileError:
            self.check(id)  # another may just have removed the thing
            raise

    def discard(self, id: str) -> None:
        """Move a thing to the trash."""
        self.check(id)
        with self._connect() as connection:
            is_discarded = discard(connection, id, self._viewer)
        if not is_discarded:
            self.check(id)  # another may have been faster
            raise self._shared()

    def remove(self, id: str) -> None:
        """Forget a thing."""
        digest = self._row(id, THINGS.c.arrays_hash).arrays_hash
        removal = THINGS.delete().where(THINGS.c.id == id, manageable(THINGS.c.owner, self._viewer))
        try:
            with self._connect() as connection:
                if connection.execute(removal.returning(THINGS.c.id)).first() is None:
                    raise self._shared()
        except IntegrityError:
            raise InUseError(
                f"the {self._kind} {id!r} is what something else was made from", value=id
            ) from None
        if digest:
            self._files.remove(id, digest)

    def check(self, id: str) -> None:
        """Raise `NotFoundError` unless the thing is there."""
        self._row(id, THINGS.c.id)

    def holds(self, id: str) -> bool:
        """Tell whether the thing is there."""
        try:
            self.check(id)
        except NotFoundError:
            return False
        return True


def _has_label(label: str) -> sa.ColumnElement[bool]:
    # A quotation mark within a label is written with a backslash: no part of a label is found.
    return sa.cast(THINGS.c.labels, sa.Text).contains(json.dumps(label), autoescape=True)


class SqlStore:
    """Everything that is kept, in a database and a place for array files, as a viewer sees it."""

    def __init__(self, connect: Connect, files: ArrayFiles, viewer: Viewer = EVERYONE) -> None:
        self._connect, self._files, self._viewer = connect, files, viewer
        self.structures = self._shelf("structure")
        self.rigs = self._shelf("rig")
        self.measurements = self._shelf("measurement")
        self.modal_models = self._shelf("modal_model")
        self.correlations = self._shelf("correlation")
        self.updates = self._shelf("update")
        self.studies = self._shelf("study")
        self.diagnoses = self._shelf("diagnosis")
        self.truths = SqlTruths(connect)
        self.trials = SqlTrials(connect)
        self.trash = SqlTrash(connect, files, viewer)
        self.projects = SqlProjects(connect, files)

    def _shelf(self, kind: str) -> SqlShelf[Any]:
        return SqlShelf(kind, CODECS[kind], self._connect, self._files, self._viewer)

    def as_seen_by(self, viewer: Viewer) -> "SqlStore":
        """Return the store in which only what is there for the viewer exists."""
        return self if viewer == self._viewer else SqlStore(self._connect, self._files, viewer)

    @property
    def unrestricted(self) -> "SqlStore":
        """The store as the service itself sees it."""
        return self.as_seen_by(EVERYONE)

    def weight(self, ids: Sequence[str], array_bytes: float, *, origins: bool) -> float:
        """Return the bytes of things, with `origins` of what they were made from, too; arrays count less."""
        with self._connect() as connection:
            return weight_of(connection, self._files, ids, array_bytes, origins=origins)

    @contextmanager
    def together(self) -> Iterator["SqlStore"]:
        """Return a store whose additions are seen all at once when the block ends, or never."""
        with self._connect() as connection:
            yield SqlStore(lambda: nullcontext(connection), self._files, self._viewer)
