"""The command `modallab convert`."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from modallab_cli import arguments
from modallab_cli.arguments import FRF_FILES, PICTURES, READ, WRITTEN, Decorator, check_output
from modallab_cli.lab import lab_of, of_file, one_sentence_per_error
from modallab_cli.outputs import check_pictures, draw, write_frfs
from modallab_client import Measurement
from modallab_client._embedded import require_service
from modallab_client.errors import InvalidInputError

_MAPPINGS = ("map", "columns", "variables")
_UNUSED = ("exciter", "window")  # assumptions that no file tells


def _each(option: str, name: str, text: str) -> Decorator:
    return click.option(option, name, multiple=True, help=f"{text}; may be repeated.")


@click.command()
@click.argument("files", type=READ, nargs=-1, required=True)
@click.argument("out", type=WRITTEN)
@click.option("--unit", help="Unit of the FRFs in the files: g/N, (m/s^2)/lbf, mm/s/N.")
@click.option("--scale", help='Factor to the unit, or else to SI: 9.81, or {"response": 9.81}.')
@click.option("--kind", help="receptance, mobility or inertance, where nothing else tells it.")
@_each("--map", "map", "DoF of a named point: wing_tip=12:+Z")
@_each("--output", "outputs", "Response DoF, in the order of the files")
@_each("--input", "inputs", "Force DoF, in the order of the files")
@_each("--column", "columns", "Column of text: freq=1, real=Re")
@_each("--variable", "variables", "Variable: freq=f, values=frf")
@click.option("--averages", type=float, help="Effective averages.")
@arguments.picture
@arguments.server
def convert(
    files: tuple[Path, ...],
    out: Path,
    averages: float | None,
    picture: Path | None,
    server: str | None,
    **given: Any,
) -> None:
    """Write the FRFs of one or more FILES of a test to OUT (.uff, .npz, .h5 or .frf), in SI units.

    Ends with 0, and with 2 if a file or an option is at fault.
    """
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
            click.echo("\n".join([f"{out}: {test.summary()}", *lines]))
            draw(test, picture)


def _converted_here(
    files: Sequence[Path], out: Path, options: dict[str, Any], averages: float | None
) -> Measurement:
    """Convert without a lab; return the FRFs."""
    require_service()
    from modallab.api.conversion import convert_files, lines_about
    from modallab.interchange.reading_options import ReadingOptions
    from modallab_cli.results import measurement_result

    measurement = convert_files(files, out, ReadingOptions(**options), averages)
    click.echo("\n".join(lines_about(measurement, out)))
    return measurement_result(measurement)


def options_of(flags: dict[str, Any]) -> dict[str, Any]:
    """Return the options of an upload that flags state: mappings as `name=value`, a scale as JSON.

    Raises
    ------
    InvalidInputError
        If a flag cannot be read.
    """
    stated = {name: value for name, value in flags.items() if value not in (None, ())}
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


def _mapping(name: str, texts: Sequence[str]) -> dict[str, Any]:
    """Return flags `name=value` as a mapping; values that several flags give one name, as a tuple."""
    mapping: dict[str, Any] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not (key and equals and value):
            raise InvalidInputError(f"--{name.removesuffix('s')} {text}: not of the form name=value")
        mapping[key] = (*mapping.get(key, ()), value) if name == "columns" else value
    return mapping
