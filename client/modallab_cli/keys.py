"""The command `modallab keys`: the first key of a service, and any other."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click

from modallab_cli.arguments import WRITTEN
from modallab_cli.settings import settings_of

_data = click.option("--data", type=WRITTEN, help="Folder for arrays and the embedded database.")
_key_id = click.argument("key_id")
_DATES = click.DateTime(["%Y-%m-%d", "%Y-%m-%dT%H:%M:%S"])


def _keys(data: Path | None) -> Any:
    """Return the book of keys; a service that runs on the same data folder does not mind."""
    from modallab.store.keys import KeyBook
    from modallab.store.place import engine_of

    settings = settings_of(data=data)
    if settings.embedded:
        settings.store_place.prepare()
    return KeyBook(engine_of(settings.store_place))


@click.group(no_args_is_help=True)
def keys() -> None:
    """Make, list, renew and revoke API keys, in the configured database."""


@keys.command()
@click.option("--role", required=True, help="admin, instructor, student or service.")
@click.option("--name", required=True, help="Name of the person or program that holds it.")
@click.option("--expires", type=_DATES, help="When it expires, UTC; left out: never.")
@_data
def create(role: str, name: str, expires: datetime | None, data: Path | None) -> None:
    """Make a key, and print it: the only time that it is told."""
    from modallab.core.errors import ModalLabError, sentence
    from modallab.store.keys import Role

    if role not in list(Role):
        raise click.BadParameter(f"{role!r} is none of {', '.join(Role)}", param_hint="--role")
    until = None if expires is None else expires.replace(tzinfo=UTC)
    try:
        new = _keys(data).create(name, Role(role), expires=until)
    except ModalLabError as error:
        raise click.BadParameter(sentence(error)) from None
    click.echo(f"Key {new.key.id} of {name}, {role}. It is told this once:", err=True)
    click.echo(new.text)


@keys.command("list")
@_data
def list_keys(data: Path | None) -> None:
    """Print all keys, newest first: id, role, state, name."""
    from modallab.store.keys import now
    from modallab.store.viewer import EVERYONE

    for key in _keys(data).list(viewer=EVERYONE):
        state = "revoked" if key.revoked else "expired" if key.expires and key.expires <= now() else "valid"
        click.echo(f"{key.id}  {key.role:10}  {state:7}  {key.name}")


@keys.command()
@_key_id
@_data
def rotate(key_id: str, data: Path | None) -> None:
    """Give a key a new text, and print it; the former one counts no more."""
    click.echo(_done(_keys(data).rotate, key_id).text)


@keys.command()
@_key_id
@_data
def revoke(key_id: str, data: Path | None) -> None:
    """Revoke a key at once and for good; what was made with it stays."""
    _done(_keys(data).revoke, key_id)


def _done(change: Any, key_id: str) -> Any:
    from modallab.core.errors import ModalLabError, sentence
    from modallab.store.viewer import EVERYONE

    try:
        return change(key_id, viewer=EVERYONE)
    except ModalLabError as error:
        raise click.BadParameter(sentence(error), param_hint="KEY_ID") from None
