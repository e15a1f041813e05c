"""The command `modallab plot`."""

import re
from pathlib import Path
from typing import Annotated

import typer

from modallab_cli.arguments import (
    PICTURES,
    Averages,
    Measured,
    OptionalRig,
    Server,
    check_output,
)
from modallab_cli.lab import lab_of, measurement_of, modes_of, one_sentence_per_error
from modallab_cli.outputs import check_pictures, draw
from modallab_client.errors import InvalidInputError

# A data set of a universal file begins with its number on the line below the delimiter.
_DATASET = re.compile(rb"^ {4}-1\s*?\n\s*(\d+)b?\b", re.MULTILINE)
_FRFS, _MODES = b"58", b"55"


def plot(
    file: Measured,
    out: Annotated[Path, typer.Argument(help="Picture to write: .png, .svg or .pdf.")],
    rig: OptionalRig = None,
    averages: Averages = None,
    kind: Annotated[str | None, typer.Option(help="Of FRFs: receptance, mobility or inertance.")] = None,
    server: Server = None,
) -> None:
    """Draw measured FRFs with their coherence, or modes: frequency and loss factor.

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
                typer.echo(model.summary())
                draw(model, out)
                return
            test = measurement_of(lab, file, rig, averages)
            test = test if kind is None else lab.measurements.get(test.id, kind=kind)
            typer.echo(test.summary())
            draw(test, out)


def _holds_modes(file: Path) -> bool:
    """Return whether a file holds modes and no FRFs: JSON, or a universal file of data sets 55."""
    if file.suffix.lower() == ".json":
        return True
    datasets = set(_DATASET.findall(file.read_bytes()))
    return _MODES in datasets and _FRFS not in datasets
