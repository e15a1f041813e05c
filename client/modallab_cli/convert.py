"""The command `modallab convert`."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from modallab_cli.arguments import (
    FRF_FILES,
    PICTURES,
    Picture,
    Server,
    check_output,
    file_argument,
)
from modallab_cli.lab import lab_of, of_file, one_sentence_per_error
from modallab_cli.outputs import check_pictures, draw, write_frfs
from modallab_client import Measurement
from modallab_client._embedded import require_service
from modallab_client.errors import InvalidInputError

_MAPPINGS = ("map", "columns", "variables")
_UNUSED = ("exciter", "window")  # assumptions that no file tells


def _each(name: str, text: str) -> Any:
    return typer.Option(name, help=f"{text}; may be repeated.")


def convert(
    files: Annotated[list[Path], file_argument("Files of one test: any format that an import takes.")],
    out: Annotated[Path, typer.Argument(help="File to write: .uff, .npz, .h5 or .frf.")],
    unit: Annotated[
        str | None, typer.Option(help="Unit of the FRFs in the files: g/N, (m/s^2)/lbf, mm/s/N.")
    ] = None,
    scale: Annotated[
        str | None, typer.Option(help='Factor to the unit, or else to SI: 9.81, or {"response": 9.81}.')
    ] = None,
    kind: Annotated[
        str | None, typer.Option(help="receptance, mobility or inertance, where nothing else tells it.")
    ] = None,
    names: Annotated[list[str] | None, _each("--map", "DoF of a named point: wing_tip=12:+Z")] = None,
    outputs: Annotated[list[str] | None, _each("--output", "Response DoF, in the order of the files")] = None,
    inputs: Annotated[list[str] | None, _each("--input", "Force DoF, in the order of the files")] = None,
    columns: Annotated[list[str] | None, _each("--column", "Column of text: freq=1, real=Re")] = None,
    variables: Annotated[list[str] | None, _each("--variable", "Variable: freq=f, values=frf")] = None,
    averages: Annotated[float | None, typer.Option(help="Effective averages.")] = None,
    picture: Picture = None,
    server: Server = None,
) -> None:
    """Write the FRFs of one or more files of a test in another format, in SI units.

    Ends with 0, and with 2 if a file or an option is at fault.
    """
    given = {"unit": unit, "scale": scale, "kind": kind, "map": names, "outputs": outputs}
    given |= {"inputs": inputs, "columns": columns, "variables": variables}
    with one_sentence_per_error("convert"):
        check_output(out, FRF_FILES, "the file to write")
        check_output(picture, PICTURES, "--plot")
        check_pictures(picture)
        options = options_of(given)
        if server is None:
            draw(_converted_here(files, out, options, averages), picture)
            return
        with lab_of(server) as lab:
            with of_file(files[0]):
                test = lab.measurements.upload(files, averages=averages, **options)
            write_frfs(lab, test, out)
            assumed = [a for a in test.assumed if a.quantity not in _UNUSED]
            lines = [f"assumed {a.quantity}: {a.value} ({a.reason})" for a in assumed]
            typer.echo("\n".join([f"{out}: {test.summary()}", *lines]))
            draw(test, picture)


def _converted_here(
    files: list[Path], out: Path, options: dict[str, Any], averages: float | None
) -> Measurement:
    """Convert without a lab; return the FRFs."""
    require_service()
    from modallab.api.conversion import convert_files, lines_about
    from modallab.interchange.reading_options import ReadingOptions
    from modallab_cli.results import measurement_result

    measurement = convert_files(files, out, ReadingOptions(**options), averages)
    typer.echo("\n".join(lines_about(measurement, out)))
    return measurement_result(measurement)


def options_of(flags: dict[str, Any]) -> dict[str, Any]:
    """Return the options of an upload that flags state: mappings as `name=value`, a scale as JSON.

    Raises
    ------
    InvalidInputError
        If a flag cannot be read.
    """
    stated = {name: value for name, value in flags.items() if value not in (None, [])}
    options = {name: _mapping(name, value) if name in _MAPPINGS else value for name, value in stated.items()}
    if "scale" in options:
        options["scale"] = _scale(str(stated["scale"]))
    return options | {name: tuple(options[name]) for name in ("outputs", "inputs") if name in options}


def _scale(text: str) -> Any:
    try:
        scale = json.loads(text)
    except ValueError:
        scale = None
    if not isinstance(scale, (int, float, dict)):
        raise InvalidInputError(f'--scale {text}: a number is needed, or JSON as {{"response": 9.81}}')
    return scale


def _mapping(name: str, texts: list[str]) -> dict[str, Any]:
    """Return flags `name=value` as a mapping; values that several flags give one name, as a tuple."""
    mapping: dict[str, Any] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not (key and equals and value):
            raise InvalidInputError(f"--{name.removesuffix('s')} {text}: not of the form name=value")
        mapping[key] = (*mapping.get(key, ()), value) if name == "columns" else value
    return mapping
