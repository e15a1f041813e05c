"""The command `modallab extract`."""

from pathlib import Path
from typing import Annotated, Any

import typer

from modallab_cli.arguments import (
    MODE_FILES,
    PICTURES,
    AsJson,
    Averages,
    Measured,
    OptionalRig,
    Picture,
    Server,
    check_output,
)
from modallab_cli.flags import pair
from modallab_cli.keywords import keywords_of
from modallab_cli.lab import ProgressLine, lab_of, measurement_of, one_sentence_per_error
from modallab_cli.outputs import check_pictures, draw, print_reply, write_modes
from modallab_client.options import ExtractionOptions

Bands = Annotated[
    list[str] | None,
    typer.Option("--bands", "--band", help="lower:upper in Hz, one mode each; of a global method more."),
]
Excluded = Annotated[
    list[str] | None, typer.Option("--exclude", help="lower:upper in Hz whose lines are left out.")
]


def extract(
    measured: Measured,
    out: Annotated[
        Path | None, typer.Option(help="Write the modes: .uff, or .json as POST /v1/modal-models/import.")
    ] = None,
    rig: OptionalRig = None,
    averages: Averages = None,
    method: Annotated[
        str | None, typer.Option(help="Extraction method; left out: by the number of force DoFs.")
    ] = None,
    n_modes: Annotated[
        int | None, typer.Option(help="Number of modes; left out: all that stand out.")
    ] = None,
    bands: Bands = None,
    exclude: Excluded = None,
    correct_window_damping: Annotated[
        bool, typer.Option(help="Take what an exponential window added out of the loss factors.")
    ] = False,
    picture: Picture = None,
    as_json: AsJson = False,
    server: Server = None,
    **flags: Any,
) -> None:
    """Read natural frequencies, loss factors and mode shapes from measured FRFs.

    Ends with 0, and with 2 if a file or an option is at fault.
    """
    with one_sentence_per_error("extract"):
        check_output(out, MODE_FILES, "--out")
        check_output(picture, PICTURES, "--plot")
        check_pictures(picture)
        keywords: Any = keywords_of(ExtractionOptions, flags)
        lines: dict[str, Any] = {
            "bands": [pair("bands", text) for text in bands or ()] or "auto",
            "exclude": [pair("exclude", text) for text in exclude or ()],
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
                typer.echo(f"{modes.table()}\n\n{modes.summary()}")
            draw(modes, picture)
