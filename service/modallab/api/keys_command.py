"""The command `modallab keys`: the first key of a service, and any other."""

from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

import typer

app = typer.Typer(
    no_args_is_help=True, help="Make, list, renew and revoke API keys, in the configured database."
)

Data = Annotated[Path | None, typer.Option(help="Folder for arrays and the embedded database.")]
KeyId = Annotated[str, typer.Argument(help="Id of the key, from `modallab keys list`.")]
_DATES = ["%Y-%m-%d", "%Y-%m-%dT%H:%M:%S"]


def settings_of(overrides: Mapping[str, Any]) -> Any:
    """Return the settings of the environment; options that are not None go before."""
    from pydantic import ValidationError

    from modallab.api.settings import ServiceSettings

    try:
        return ServiceSettings(**{name: value for name, value in overrides.items() if value is not None})
    except ValidationError as error:
        fault = error.errors()[0]
        raise typer.BadParameter(f"{'.'.join(map(str, fault['loc']))}: {fault['msg']}") from None


def _keys(data: Path | None) -> Any:
    """Return the book of keys; a service that runs on the same data folder does not mind."""
    from modallab.store.keys import KeyBook
    from modallab.store.place import engine_of

    settings = settings_of({"data": data})
    if settings.embedded:
        settings.store_place.prepare()
    return KeyBook(engine_of(settings.store_place))


@app.command()
def create(
    role: Annotated[str, typer.Option(help="admin, instructor, student or service.")],
    name: Annotated[str, typer.Option(help="Name of the person or program that holds it.")],
    expires: Annotated[
        datetime | None, typer.Option(formats=_DATES, help="When it expires, UTC; left out: never.")
    ] = None,
    data: Data = None,
) -> None:
    """Make a key, and print it: the only time that it is told."""
    from modallab.core.errors import ModalLabError, sentence
    from modallab.store.keys import Role

    if role not in list(Role):
        raise typer.BadParameter(f"{role!r} is none of {', '.join(Role)}", param_hint="--role")
    until = None if expires is None else expires.replace(tzinfo=UTC)
    try:
        new = _keys(data).create(name, Role(role), expires=until)
    except ModalLabError as error:
        raise typer.BadParameter(sentence(error)) from None
    typer.echo(f"Key {new.key.id} of {name}, {role}. It is told this once:", err=True)
    typer.echo(new.text)


@app.command("list")
def list_keys(data: Data = None) -> None:
    """Print all keys, newest first: id, role, state, name."""
    from modallab.store.keys import now
    from modallab.store.viewer import EVERYONE

    for key in _keys(data).list(viewer=EVERYONE):
        state = "revoked" if key.revoked else "expired" if key.expires and key.expires <= now() else "valid"
        typer.echo(f"{key.id}  {key.role:10}  {state:7}  {key.name}")


@app.command()
def rotate(key_id: KeyId, data: Data = None) -> None:
    """Give a key a new text, and print it; the former one counts no more."""
    typer.echo(_done(_keys(data).rotate, key_id).text)


@app.command()
def revoke(key_id: KeyId, data: Data = None) -> None:
    """Revoke a key at once and for good; what was made with it stays."""
    _done(_keys(data).revoke, key_id)


def _done(change: Any, key_id: str) -> Any:
    from modallab.core.errors import ModalLabError, sentence
    from modallab.store.viewer import EVERYONE

    try:
        return change(key_id, viewer=EVERYONE)
    except ModalLabError as error:
        raise typer.BadParameter(sentence(error), param_hint="KEY_ID") from None
