"""The command `modallab measure`."""

from pathlib import Path
from typing import Any

import click

from modallab_cli import arguments
from modallab_cli.arguments import FRF_FILES, PICTURES, WRITTEN, check_output
from modallab_cli.keywords import keywords_of, with_keywords
from modallab_cli.lab import ProgressLine, lab_of, one_sentence_per_error, rig_id_of, structure_of
from modallab_cli.outputs import check_pictures, draw, print_reply, write_frfs
from modallab_client.options import MeasurementOptions


@click.command()
@arguments.model
@arguments.rig
@click.option("--out", required=True, type=WRITTEN, help="File to write: .uff, .npz, .h5 or .frf.")
@arguments.mesh
@arguments.picture
@arguments.as_json
@arguments.server
@with_keywords(MeasurementOptions)
def measure(
    model: Path,
    rig: Path,
    out: Path,
    mesh: Path | None,
    picture: Path | None,
    as_json: bool,
    server: str | None,
    **flags: Any,
) -> None:
    """Measure a structure on the virtual rig, and write the FRFs.

    Ends with 0, and with 2 if a file or an option is at fault.
    """
    with one_sentence_per_error("measure"):
        check_output(out, FRF_FILES, "--out")
        check_output(picture, PICTURES, "--plot")
        check_pictures(picture)
        keywords: Any = keywords_of(MeasurementOptions, flags)
        with lab_of(server) as lab, ProgressLine() as progress:
            structure, rig_id = structure_of(lab, model, mesh), str(rig_id_of(lab, rig))
            test = lab.measurements.start(structure.id, rig_id, **keywords).result(progress)
            write_frfs(lab, test, out)
            if as_json:
                print_reply(lab, f"/v1/measurements/{test.id}", stays=server is not None)
            else:
                click.echo(f"{out}: {test.summary()}")
            draw(test, picture)
