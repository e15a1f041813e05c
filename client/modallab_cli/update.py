"""The command `modallab update`."""

import json
from pathlib import Path
from typing import Any

import click

from modallab_cli import arguments
from modallab_cli.arguments import PICTURES, READ, WRITTEN, check_output
from modallab_cli.flags import pair
from modallab_cli.keywords import keywords_of, with_keywords
from modallab_cli.lab import (
    ProgressLine,
    lab_of,
    measurement_of,
    modes_of,
    one_sentence_per_error,
    structure_of,
)
from modallab_cli.outputs import check_pictures, draw, print_reply
from modallab_client.errors import InvalidInputError
from modallab_client.options import UpdateOptions

_OF_THE_REQUEST = ("parts", "lower", "upper", "macros", "bands", "exclude", "noise_floor")


@click.command()
@arguments.model
@click.option("--modes", type=READ, help="Measured modes: universal file (55) or JSON of `modallab extract`.")
@click.option("--measured", type=READ, help="In place of modes, for a method that takes FRFs: measured FRFs.")
@arguments.optional_rig
@arguments.averages
@arguments.mesh
@click.option("--method", default="inverse_eigensensitivity", show_default=True, help="Updating method.")
@click.option("--macros", help="auto, each, or JSON: lists of members, names of groups, a rule.")
@click.option(
    "--parts", "--part", "parts", multiple=True, help="mass, stiffness, damping, modulus; may be repeated."
)
@click.option("--lower", type=float, help="Lower bound of every coefficient.")
@click.option("--upper", type=float, help="Upper bound of every coefficient.")
@arguments.bands
@arguments.exclude
@click.option("--noise-floor", type=float, help="Relative random error of FRFs beside what coherence tells.")
@click.option("--out", type=WRITTEN, help="Write the whole result: .json.")
@arguments.picture
@arguments.as_json
@arguments.server
@with_keywords(UpdateOptions)
def update(
    model: Path,
    modes: Path | None,
    measured: Path | None,
    rig: Path | None,
    averages: float | None,
    mesh: Path | None,
    method: str,
    out: Path | None,
    picture: Path | None,
    as_json: bool,
    server: str | None,
    **flags: Any,
) -> None:
    """Correct a model until its modes, or its FRFs, are the measured ones.

    Ends with 0, and with 2 if a file or an option is at fault.
    """
    with one_sentence_per_error("update"):
        check_output(out, (".json",), "--out")
        check_output(picture, PICTURES, "--plot")
        check_pictures(picture)
        if (modes is None) == (measured is None):
            raise InvalidInputError("an update takes either --modes or --measured")
        keywords = _keywords(flags)
        with lab_of(server) as lab, ProgressLine() as progress:
            structure = structure_of(lab, model, mesh)
            sources: dict[str, Any] = {
                "modal_model_id": None if modes is None else modes_of(lab, modes).id,
                "measurement_id": None
                if measured is None
                else measurement_of(lab, measured, rig, averages).id,
            }
            job = lab.updates.start(structure.id, method=method, **sources, **keywords)
            result = job.result(progress)
            path = f"/v1/updates/{result.id}"
            if out is not None:
                out.write_text(json.dumps(lab.request("GET", path), indent=1), encoding="utf-8")
            if as_json:
                print_reply(lab, path, stays=server is not None)
            else:
                click.echo(f"{result.table()}\n\n{result.summary()}")
            draw(result, picture)


def _keywords(flags: dict[str, Any]) -> dict[str, Any]:
    """Return the keywords of the job that flags state."""
    options = {name: value for name, value in flags.items() if name not in _OF_THE_REQUEST}
    return keywords_of(UpdateOptions, options) | {
        "parts": list(flags["parts"]) or None,
        "lower": flags["lower"],
        "upper": flags["upper"],
        "macros": _macros(flags["macros"]),
        "bands": [pair("bands", text) for text in flags["bands"]] or None,
        "exclude": [pair("exclude", text) for text in flags["exclude"]],
        "noise_floor": flags["noise_floor"],
    }


def _macros(text: str | None) -> Any:
    if text is None or not text.startswith(("[", "{")):
        return text
    try:
        return json.loads(text)
    except ValueError:
        raise InvalidInputError(f"--macros: not JSON: {text}") from None
