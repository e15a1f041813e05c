"""A lab as one file, made while it works, and made into a lab again."""

import io
import json
import tarfile
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import sqlalchemy as sa

import modallab
from modallab.core.errors import InvalidInputError
from modallab.store.arrays import FolderArrays
from modallab.store.base import MissingFileError, StoredDataError
from modallab.store.migrate import migrate, newest_revision, revision_of
from modallab.store.place import StorePlace, engine_of
from modallab.store.tables import EXECUTORS, METADATA

_MANIFEST, _ROWS, _ARRAYS = "manifest.json", "rows.jsonl", "arrays"
_FORMAT = 1
_MOST_READINGS = 20  # while things are removed at the same time
# Processes that live now; jobs that have not ended are queued anew in the restored lab.
_TABLES = [table for table in METADATA.sorted_tables if table is not EXECUTORS]
Row = dict[str, Any]


def back_up(place: StorePlace, file: IO[bytes]) -> dict[str, int]:
    """Write everything that a lab keeps to a file, as of one moment; return the number of rows by table.

    Raises
    ------
    StoredDataError
        If an array file is damaged, or the database has another schema.
    """
    engine, files = engine_of(place), FolderArrays(place.folder)
    _check_schema(engine)
    with tarfile.open(fileobj=file, mode="w|") as archive:
        copied: set[str] = set()
        for _ in range(_MOST_READINGS):
            with tempfile.TemporaryFile() as rows:
                counts, arrays = _read(engine, rows)
                # A thing that is removed now is in the rows and has no file: read both again.
                if all(_copied(archive, files, copied, *named) for named in arrays):
                    rows.seek(0, io.SEEK_END)
                    header = tarfile.TarInfo(_ROWS)
                    header.size = rows.tell()
                    rows.seek(0)
                    archive.addfile(header, rows)
                    about = {
                        "format": _FORMAT,
                        "revision": newest_revision(),
                        "version": modallab.__version__,
                    }
                    _add(archive, _MANIFEST, json.dumps(about | {"rows": counts}).encode())
                    return counts
    raise StoredDataError("array files are gone, or things are removed faster than they can be copied")


def _check_schema(engine: sa.Engine) -> None:
    if revision_of(engine) != newest_revision():
        raise StoredDataError("the database has the schema of another version: run `modallab init` first")


def _read(engine: sa.Engine, rows: IO[bytes]) -> tuple[dict[str, int], list[tuple[str, str]]]:
    """Write all rows of one moment as lines; return their numbers, and ids and digests of array files."""
    counts, arrays = dict[str, int](), list[tuple[str, str]]()
    with engine.connect().execution_options(**_snapshot(engine)) as connection:
        if engine.dialect.name == "sqlite":
            connection.exec_driver_sql("BEGIN")  # or each question would see another moment
        for table in _TABLES:
            counts[table.name] = 0
            for found in connection.execution_options(yield_per=100).execute(sa.select(table)):
                row = found._asdict()
                rows.write(json.dumps([table.name, row]).encode() + b"\n")
                counts[table.name] += 1
                if row.get("arrays_hash"):
                    arrays.append((row["id"], row["arrays_hash"]))
        connection.rollback()
    return counts, arrays


def _snapshot(engine: sa.Engine) -> dict[str, Any]:
    return {} if engine.dialect.name == "sqlite" else {"isolation_level": "REPEATABLE READ"}


def _copied(archive: tarfile.TarFile, files: FolderArrays, copied: set[str], id: str, digest: str) -> bool:
    """Copy an array file unless it was, and tell whether it is there."""
    name = f"{_ARRAYS}/{id}.{digest}"
    if name not in copied:
        try:
            payload = files.get(id, digest)
        except MissingFileError:
            return False
        _add(archive, name, payload)
        copied.add(name)
    return True


def _add(archive: tarfile.TarFile, name: str, payload: bytes) -> None:
    header = tarfile.TarInfo(name)
    header.size = len(payload)
    archive.addfile(header, io.BytesIO(payload))


def restore(place: StorePlace, path: Path) -> dict[str, int]:
    """Make an empty place into the lab of a backup; return the number of rows by table.

    Raises
    ------
    InvalidInputError
        If the place is not empty, or the file no backup that this version can read.
    StoredDataError
        If the backup is damaged; the place then stays empty.
    """
    engine, files = engine_of(place), FolderArrays(place.folder)
    try:
        with tarfile.open(path) as archive:
            about = json.loads(_member(archive, _MANIFEST).read())
            _prepare(engine, place, about)
            with engine.begin() as connection:
                counts = _write(connection, archive, files)
    except (tarfile.TarError, KeyError, ValueError, EOFError) as error:
        if isinstance(error, InvalidInputError):
            raise
        raise InvalidInputError(
            f"{path} is no whole backup: {error}", field="file", value=str(path)
        ) from None
    migrate(engine, schema=place.schema)
    return counts


def _prepare(engine: sa.Engine, place: StorePlace, about: dict[str, Any]) -> None:
    """Create empty tables as they were when a backup was made."""
    place.folder.mkdir(parents=True, exist_ok=True)
    if about["format"] != _FORMAT:
        raise InvalidInputError("a later version made this backup", field="file", value=about["version"])
    if any(entry.is_file() for entry in place.folder.rglob("*")) or _holds_rows(engine):
        raise InvalidInputError(
            "a backup is restored into an empty place only", field="data", value=str(place.folder.parent)
        )
    migrate(engine, schema=place.schema, revision=about["revision"])


def _holds_rows(engine: sa.Engine) -> bool:
    existing = set(sa.inspect(engine).get_table_names())
    with engine.connect() as connection:
        return any(
            connection.execute(sa.select(table).limit(1)).first() is not None
            for table in METADATA.sorted_tables
            if table.name in existing
        )


def _write(connection: sa.Connection, archive: tarfile.TarFile, files: FolderArrays) -> dict[str, int]:
    tables = sa.MetaData()
    tables.reflect(connection)
    counts, put = dict[str, int](), list[tuple[str, str]]()
    try:
        for name, row in _rows(_member(archive, _ROWS)):
            if digest := row.get("arrays_hash"):
                payload = _member(archive, f"{_ARRAYS}/{row['id']}.{digest}").read()
                put.append((row["id"], files.put(row["id"], payload)))
                if put[-1][1] != digest:
                    raise StoredDataError("an array file of the backup is damaged", id=row["id"])
            connection.execute(tables.tables[_key(tables, name)].insert().values(**row))
            counts[name] = counts.get(name, 0) + 1
    except BaseException:
        for id, digest in put:
            files.remove(id, digest)
        raise
    return counts


def _key(tables: sa.MetaData, name: str) -> str:
    return next(key for key, table in tables.tables.items() if table.name == name)


def _rows(file: IO[bytes]) -> Iterator[tuple[str, Row]]:
    for line in file:
        name, row = json.loads(line)
        yield name, row


def _member(archive: tarfile.TarFile, name: str) -> IO[bytes]:
    member = archive.extractfile(name)
    if member is None:
        raise KeyError(name)
    return member
