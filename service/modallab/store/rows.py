"""Ids of rows, and their insertion."""

import secrets
from collections.abc import Mapping
from typing import Any

import sqlalchemy as sa
from sqlalchemy.dialects import postgresql, sqlite


def new_id() -> str:
    """Return an id that says nothing and cannot be guessed."""
    return secrets.token_hex(12)


def insert_once(connection: sa.Connection, table: sa.Table, row: Mapping[str, Any]) -> bool:
    """Insert a row and tell whether it was not there before."""
    dialect = postgresql if connection.dialect.name == "postgresql" else sqlite
    # rowcount is -1 for some drivers; RETURNING says for certain whether a row went in.
    first = next(iter(table.primary_key.columns))
    statement = dialect.insert(table).values(**row).on_conflict_do_nothing().returning(first)
    return connection.execute(statement).first() is not None
