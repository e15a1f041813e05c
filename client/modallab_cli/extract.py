"""The command `modallab extract`."""

from pathlib import Path
from typing import Any

import click

from modallab_cli import arguments
from modallab_cli.arguments import MODE_FILES, PICTURES, WRITTEN, check_output
from modallab_cli.flags import pair
from modallab_cli.keywords import keywords_of, with_keywords
from modallab_cli.lab import ProgressLine, lab_of, measurement_of, one_sentence_per_error
from modallab_cli.outputs import check_pictures, draw, print_reply, write_modes
from modallab_client.options import ExtractionOptions


@click.command()
@arguments.measured
@click.option("--out", type=WRITTEN, help="Write the modes: .uff, or .json as POST /v1/modal-models/import.")
@arguments.optional_rig
@arguments.averages
@click.option("--method", help="Extraction method; left out: by the number of force DoFs.")
@click.option("--n-modes", type=int, help="Number of modes; left out: all that stand out.")
@arguments.bands
@arguments.exclude
@click.option(
    "--correct-window-damping",
    is_flag=True,
    help="Take what an exponential window added out of the loss factors.",
)
@arguments.picture
@arguments.as_json
@arguments.server
@with_keywords(ExtractionOptions)
def extract(
    measured: Path,
    out: Path | None,
    rig: Path | None,
    averages: float | None,
    method: str | None,
    n_modes: int | None,
    bands: tuple[str, ...],
    exclude: tuple[str, ...],
    correct_window_damping: bool,
    picture: Path | None,
    as_json: bool,
    server: str | None,
    **flags: Any,
) -> None:
    """Read natural frequencies, loss factors and mode shapes from the FRFs of the file MEASURED.

    Ends with 0, and with 2 if a file or an option is at fault.
    """
    with one_sentence_per_error("extract"):
        check_output(out, MODE_FILES, "--out")
        check_output(picture, PICTURES, "--plot")
        check_pictures(picture)
        keywords: Any = keywords_of(ExtractionOptions, flags)
        lines: dict[str, Any] = {
            "bands": [pair("bands", text) for text in bands] or "auto",
            "exclude": [pair("exclude", text) for text in exclude],
        }
        with lab_of(server) as lab, ProgressLine() as progress:
            test = measurement_of(lab, measured, rig, averages)
            job = lab.modal_models.start(
                test.id,
                method=method,
                n_modes=n_modes,
                correct_window_damping=correct_window_damping,
                **lines,
                **keywords,
            )
            modes = job.result(progress)
            if out is not None:
                write_modes(lab, modes, out)
            if as_json:
                print_reply(lab, f"/v1/modal-models/{modes.id}", stays=server is not None)
            else:
                click.echo(f"{modes.table()}\n\n{modes.summary()}")
            if picture is not None:
                draw(lab.modal_models.frf(modes.id), picture, test)
