"""The command `modallab update`."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from modallab_cli.arguments import (
    PICTURES,
    AsJson,
    Averages,
    MeshGroups,
    Model,
    OptionalRig,
    Picture,
    Server,
    check_output,
    file_option,
)
from modallab_cli.extract import Excluded
from modallab_cli.flags import pair
from modallab_cli.keywords import keywords_of
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


def update(
    model: Model,
    modes: Annotated[
        Path | None, file_option("Measured modes: universal file (55) or the JSON of `modallab extract`.")
    ] = None,
    measured: Annotated[
        Path | None, file_option("In place of modes, for a method that takes FRFs: measured FRFs.")
    ] = None,
    rig: OptionalRig = None,
    averages: Averages = None,
    mesh: MeshGroups = None,
    method: Annotated[str, typer.Option(help="Updating method.")] = "inverse_eigensensitivity",
    macros: Annotated[
        str | None,
        typer.Option(help="Macro elements: auto, each, or JSON: lists of members, names of groups, a rule."),
    ] = None,
    parts: Annotated[
        list[str] | None,
        typer.Option("--parts", "--part", help="mass, stiffness, damping, modulus ...; may be repeated."),
    ] = None,
    lower: Annotated[float | None, typer.Option(help="Lower bound of every coefficient.")] = None,
    upper: Annotated[float | None, typer.Option(help="Upper bound of every coefficient.")] = None,
    bands: Annotated[
        list[str] | None, typer.Option("--bands", "--band", help="lower:upper in Hz of FRFs that count.")
    ] = None,
    exclude: Excluded = None,
    noise_floor: Annotated[
        float | None, typer.Option(help="Relative random error of every FRF beside what coherence tells.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Write the whole result: .json.")] = None,
    picture: Picture = None,
    as_json: AsJson = False,
    server: Server = None,
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
        keywords: Any = keywords_of(UpdateOptions, flags)
        coefficients: dict[str, Any] = {
            "parts": parts or None,
            "lower": lower,
            "upper": upper,
            "macros": _macros(macros),
        }
        lines: dict[str, Any] = {
            "bands": [pair("bands", text) for text in bands or ()] or None,
            "exclude": [pair("exclude", text) for text in exclude or ()],
            "noise_floor": noise_floor,
        }
        with lab_of(server) as lab, ProgressLine() as progress:
            structure = structure_of(lab, model, mesh)
            sources: dict[str, Any] = {
                "modal_model_id": None if modes is None else modes_of(lab, modes).id,
                "measurement_id": None
                if measured is None
                else measurement_of(lab, measured, rig, averages).id,
            }
            job = lab.updates.start(
                structure.id, method=method, **sources, **coefficients, **lines, **keywords
            )
            result = job.result(progress)
            path = f"/v1/updates/{result.id}"
            if out is not None:
                out.write_text(json.dumps(lab.request("GET", path), indent=1), encoding="utf-8")
            if as_json:
                print_reply(lab, path, stays=server is not None)
            else:
                typer.echo(f"{result.table()}\n\n{result.summary()}")
            draw(result, picture)


def _macros(text: str | None) -> Any:
    if text is None or not text.startswith(("[", "{")):
        return text
    try:
        return json.loads(text)
    except ValueError:
        raise InvalidInputError(f"--macros: not JSON: {text}") from None
