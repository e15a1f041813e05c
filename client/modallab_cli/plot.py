"""The command `modallab plot`."""

import re
from pathlib import Path

import click

from modallab_cli import arguments
from modallab_cli.arguments import PICTURES, READ, WRITTEN, check_output
from modallab_cli.lab import lab_of, measurement_of, modes_of, one_sentence_per_error
from modallab_cli.outputs import check_pictures, draw
from modallab_client.errors import InvalidInputError

# A data set of a universal file begins with its number on the line below the delimiter.
_DATASET = re.compile(rb"^ {4}-1\s*?\n\s*(\d+)b?\b", re.MULTILINE)
_FRFS, _MODES = b"58", b"55"


@click.command()
@click.argument("file", type=READ)
@click.argument("out", type=WRITTEN)
@arguments.optional_rig
@arguments.averages
@click.option("--kind", help="Of FRFs: receptance, mobility or inertance.")
@arguments.server
def plot(
    file: Path, out: Path, rig: Path | None, averages: float | None, kind: str | None, server: str | None
) -> None:
    """Draw FILE, FRFs with their coherence or modes, into the picture OUT (.png, .svg or .pdf).

    Ends with 0, and with 2 if a file or an option is at fault.
    """
    with one_sentence_per_error("plot"):
        check_output(out, PICTURES, "the picture")
        check_pictures(out)
        modes = _holds_modes(file)
        if modes and kind is not None:
            raise InvalidInputError(f"{file.name} holds modes, which have no kind")
        with lab_of(server) as lab:
            if modes:
                model = modes_of(lab, file)
                click.echo(model.summary())
                draw(model, out)
                return
            test = measurement_of(lab, file, rig, averages)
            test = test if kind is None else lab.measurements.get(test.id, kind=kind)
            click.echo(test.summary())
            draw(test, out)


def _holds_modes(file: Path) -> bool:
    """Return whether a file holds modes and no FRFs: JSON, or a universal file of data sets 55."""
    if file.suffix.lower() == ".json":
        return True
    datasets = set(_DATASET.findall(file.read_bytes()))
    return _MODES in datasets and _FRFS not in datasets
