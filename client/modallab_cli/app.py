"""The `modallab` command and its parts."""

from collections.abc import Callable, Sequence
from importlib.metadata import version
from importlib.util import find_spec
from typing import Annotated

import typer

from modallab.diagnosis.options import DiagnosisOptions
from modallab_cli import service
from modallab_cli.convert import convert
from modallab_cli.diagnose import diagnose
from modallab_cli.extract import extract
from modallab_cli.flags import with_flags
from modallab_cli.keywords import with_keywords
from modallab_cli.lab import fault
from modallab_cli.measure import measure
from modallab_cli.openapi import openapi
from modallab_cli.plot import plot
from modallab_cli.update import update
from modallab_client.options import ExtractionOptions, MeasurementOptions, UpdateOptions

ABOUT = """A virtual modal-testing lab: measure, extract, update and diagnose on files, or serve it over HTTP.

Measure, extract, update, diagnose, convert, plot and openapi need no running service: they work on this
computer, or with --server URL in a lab elsewhere.
"""
NEEDS_SERVICE = "the service is not installed: pip install 'modallab[service]'"

app = typer.Typer(no_args_is_help=True, add_completion=False, help=ABOUT)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"modallab {version('modallab')}")
        raise typer.Exit


@app.callback()
def modallab(
    show: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Take the options that stand before a command."""


app.command()(with_keywords(measure, MeasurementOptions))
app.command()(with_keywords(extract, ExtractionOptions))
app.command()(with_keywords(update, UpdateOptions))
# Files have no rig that could run the proposed tests.
app.command()(with_flags(diagnose, DiagnosisOptions, without=("act",)))
app.command()(convert)
app.command()(plot)
app.command()(openapi)


def _missing(command: Callable[..., None]) -> Callable[[], None]:
    """Return a command that names the extra to install, in place of one that is not installed."""

    def missing() -> None:
        raise fault(command.__name__, NEEDS_SERVICE)

    missing.__name__, missing.__doc__ = command.__name__, command.__doc__
    return missing


_SERVICE: Sequence[Callable[..., None]] = (service.serve, service.worker, service.init, service.demo)
_ANYTHING = {"allow_extra_args": True, "ignore_unknown_options": True}
for command in _SERVICE:
    if find_spec("fastapi") is None:
        app.command(context_settings=_ANYTHING)(_missing(command))
    else:
        app.command()(command)
