"""The commands `modallab export` and `modallab import`: what one has in a lab as one file."""

import json
import zipfile
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import click

from modallab_cli import arguments
from modallab_cli.arguments import READ, WRITTEN, check_output
from modallab_cli.lab import lab_of, one_sentence_per_error

_ENDINGS = (".zip",)


@click.command("export")
@click.argument("file", type=WRITTEN)
@click.option("--label", help="Only what has this label, and what that was made from.")
@arguments.lab
def export_project(file: Path, label: str | None, server: str) -> None:
    """Write what one has in a lab to one file, .zip, for another lab or for the same one."""
    with one_sentence_per_error("export"):
        check_output(file, _ENDINGS, "the file")
        with lab_of(server) as lab:
            lab.projects.download(file, label=label)
    with zipfile.ZipFile(file) as archive:
        contents = json.loads(archive.read("project.json"))
    click.echo(f"{file}: {_words(Counter(thing['kind'] for thing in contents['things']))}")
    if left_out := contents["left_out"]:
        click.echo(f"left out: {len(left_out)}, of assignments or made from what others have", err=True)


@click.command("import")
@click.argument("file", type=READ)
@arguments.lab
def import_project(file: Path, server: str) -> None:
    """Store what is in a file of `modallab export` in a lab, where it is one's own."""
    with one_sentence_per_error("import"), lab_of(server) as lab:
        click.echo(f"{file}: {_words(lab.projects.upload(file).counts)}")


def _words(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{n} {kind.replace('_', ' ')}" for kind, n in counts.items()) or "nothing"
