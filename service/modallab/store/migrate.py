"""Bring a database to the tables of this version."""

from pathlib import Path

import sqlalchemy as sa
from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from alembic.util import CommandError

from modallab.store.base import StoredDataError

_SCRIPTS = Path(__file__).parent / "migrations"


def alembic_config(connection: sa.Connection) -> Config:
    """Return the configuration alembic needs: no file of its own, the open connection."""
    config = Config()
    config.set_main_option("script_location", str(_SCRIPTS))
    config.attributes["connection"] = connection
    return config


def newest_revision() -> str:
    """Return the revision of the tables of this version."""
    return str(ScriptDirectory(str(_SCRIPTS)).get_current_head())


def revision_of(engine: sa.Engine) -> str | None:
    """Return the revision of the tables of a database; None without tables."""
    with engine.connect() as connection:
        return MigrationContext.configure(connection).get_current_revision()


def migrate(engine: sa.Engine, *, schema: str, revision: str = "head") -> None:
    """Create what is missing and change what is old; nothing happens to an up-to-date database.

    Raises
    ------
    StoredDataError
        If a later version of modallab has changed the tables.
    """
    with engine.begin() as connection:
        if connection.dialect.name == "postgresql":
            connection.execute(sa.schema.CreateSchema(schema, if_not_exists=True))
        try:
            command.upgrade(alembic_config(connection), revision)
        except CommandError as error:
            raise StoredDataError(
                f"a later version of modallab has changed the database: {error}",
                allowed="that version, or a later one",
            ) from None
