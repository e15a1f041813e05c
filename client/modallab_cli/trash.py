"""The command `modallab trash`: what was deleted in a lab, to be restored within a day."""

import click

from modallab_cli import arguments
from modallab_cli.lab import lab_of, one_sentence_per_error

_thing = click.argument("id")


@click.group(no_args_is_help=True)
def trash() -> None:
    """List, restore and remove for good what was deleted in a lab."""


@trash.command("list")
@arguments.lab
def list_trash(server: str) -> None:
    """Print what is in the trash, last deleted first: id, kind, time until which it is there, name."""
    with one_sentence_per_error("trash list"), lab_of(server) as lab:
        for thing in lab.trash.list():
            click.echo(f"{thing.id}  {thing.kind:11}  {thing.until[:16]}  {thing.name}")


@trash.command()
@_thing
@arguments.lab
def restore(id: str, server: str) -> None:
    """Take something out of the trash; it has its id, name, labels and shares as before."""
    with one_sentence_per_error("trash restore"), lab_of(server) as lab:
        lab.trash.restore(id)


@trash.command()
@_thing
@arguments.lab
def remove(id: str, server: str) -> None:
    """Remove something in the trash for good."""
    with one_sentence_per_error("trash remove"), lab_of(server) as lab:
        lab.trash.remove(id)
