"""What is checked before the service starts; what is wrong is told in one sentence, with exit code 3."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import click
import sqlalchemy as sa

from modallab.api.settings import ServiceSettings
from modallab.core.errors import ModalLabError, sentence
from modallab.store.base import StoredDataError

UNUSABLE = 3  # exit code


@contextmanager
def told_in_a_sentence() -> Iterator[None]:
    """End the command with a sentence where database or disk cannot be used."""
    try:
        yield
    except ModalLabError as error:
        _end(sentence(error))
    except sa.exc.DBAPIError as error:
        _end(f"the database cannot be used: {str(error.orig).splitlines()[0]}")
    except (sqlite3.Error, OSError) as error:
        _end(f"the data folder cannot be used: {error}")


def _end(message: str) -> None:
    click.echo(f"modallab: {message}", err=True)
    raise click.exceptions.Exit(UNUSABLE)


def prepare(settings: ServiceSettings) -> None:
    """Check the databases, and create their tables or bring them up to date."""
    with told_in_a_sentence():
        for place in (settings.store_place, settings.job_place):
            if (name := sa.make_url(place.url).database) and place.url.startswith("sqlite"):
                _check(Path(name))
        settings.store_place.prepare()
        settings.job_place.prepare()


def _check(file: Path) -> None:
    """Raise `StoredDataError` if a file is a damaged database; one that is missing is created later."""
    if not file.exists():
        return
    with closing(sqlite3.connect(f"{file.absolute().as_uri()}?mode=rw", uri=True, timeout=30)) as connection:
        try:
            found = connection.execute("PRAGMA quick_check(1)").fetchone()[0]
        except sqlite3.DatabaseError as error:
            if isinstance(error, sqlite3.OperationalError):
                raise
            found = str(error)
    if found != "ok":
        *_, last = str(found).splitlines()
        raise StoredDataError(f"the database {file} is damaged ({last}): restore a backup into a new folder")


def lock_of(folder: Path) -> sqlite3.Connection:
    """Return the lock of a data folder; this process holds it until it ends.

    Raises
    ------
    BadParameter
        If another process holds it.
    """
    with told_in_a_sentence():
        folder.mkdir(parents=True, exist_ok=True)
        lock = sqlite3.connect(folder / "lock", isolation_level=None, timeout=0)
        try:
            lock.execute("BEGIN EXCLUSIVE")
        except sqlite3.OperationalError as error:
            if "locked" not in str(error):
                raise
            raise click.BadParameter(f"another service works in {folder}", param_hint="--data") from None
    return lock
