"""The command `modallab convert`."""

from pathlib import Path
from typing import Annotated, Any

import typer


def _file(text: str) -> Any:
    return typer.Argument(exists=True, dir_okay=False, readable=True, help=text)


def _each(name: str, text: str) -> Any:
    return typer.Option(name, help=f"{text}; may be repeated.")


def convert(
    files: Annotated[list[Path], _file("Files of one test: any format that an import takes.")],
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
) -> None:
    """Write the FRFs of one or more files of a test in another format, in SI units.

    Ends with 0, and with 2 if a file or an option is at fault.
    """
    from modallab.api.conversion import convert_files, options_of
    from modallab.core.errors import ModalLabError, sentence

    flags = {"unit": unit, "scale": scale, "kind": kind, "map": names, "outputs": outputs}
    flags |= {"inputs": inputs, "columns": columns, "variables": variables}
    try:
        lines = convert_files(files, out, options_of(flags), averages)
    except ModalLabError as error:
        typer.echo(f"modallab convert: {sentence(error)}", err=True)
        raise typer.Exit(2) from None
    typer.echo("\n".join(lines))
