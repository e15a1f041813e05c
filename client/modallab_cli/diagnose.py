"""The command `modallab diagnose`."""

import json
import shlex
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from modallab.diagnosis.options import DiagnosisOptions
from modallab_cli import arguments
from modallab_cli.arguments import PICTURES, READ, WRITTEN, check_output
from modallab_cli.flags import request_of, with_options
from modallab_cli.lab import ProgressLine, lab_of, measurement_of, one_sentence_per_error, structure_of
from modallab_cli.outputs import check_pictures, draw
from modallab_client import Diagnosis
from modallab_client._embedded import require_service
from modallab_client._plausibility import warn_of

_HEADING = ("title", "object", "author", "date")


@dataclass(frozen=True)
class _Inputs:
    """Files and options of a diagnosis."""

    model: Path
    measured: Path
    rig: Path
    mesh: Path | None
    averages: float | None
    request: Mapping[str, Any]
    heading: Mapping[str, str]
    """Title, object, author and date of the report, those that are given."""


@dataclass(frozen=True)
class _Outcome:
    """A diagnosis, in the forms that the command writes."""

    words: str
    reply: str
    page: Callable[[], str]
    result: Callable[[], Diagnosis]


@click.command()
@arguments.model
@click.option(
    "--measured",
    required=True,
    type=READ,
    help="FRFs: universal file, npz, HDF5, or the thesis program's text.",
)
@arguments.rig
@arguments.mesh
@click.option("--report", type=WRITTEN, help="Write the report, one HTML page, to this file.")
@click.option("--title", help="Title of the report.")
@click.option("--object", help="Object that was tested, for the report.")
@click.option("--author", help="Author, for the report.")
@click.option("--date", help="Date, for the report.")
@arguments.averages
@arguments.picture
@arguments.as_json
@arguments.server
@with_options(DiagnosisOptions, without=("act",))  # files have no rig that could run the proposed tests
def diagnose(
    model: Path,
    measured: Path,
    rig: Path,
    mesh: Path | None,
    report: Path | None,
    averages: float | None,
    picture: Path | None,
    as_json: bool,
    server: str | None,
    **flags: Any,
) -> None:
    """Say what a model or a log book lacks to explain measured FRFs: what, where, how much, how sure.

    Ends with 0 whatever the verdict, and with 2 if a file or an option is at fault.
    """
    heading = {name: flags.pop(name) for name in _HEADING}
    stated = {name: text for name, text in heading.items() if text is not None}
    request = request_of(DiagnosisOptions, flags)
    inputs = _Inputs(model, measured, rig, mesh, averages, request, stated)
    with one_sentence_per_error("diagnose"):
        check_output(report, (".html", ".htm"), "--report")
        check_output(picture, PICTURES, "--plot")
        check_pictures(picture)
        with ProgressLine() as progress:
            outcome = _here(inputs, progress) if server is None else _at(server, inputs, progress)
        click.echo(outcome.reply if as_json else outcome.words)
        if report is not None:
            report.write_text(outcome.page(), encoding="utf-8")
            click.echo(f"The report: {report.resolve()}", err=as_json)
        if picture is not None:
            draw(outcome.result(), picture)


def _here(inputs: _Inputs, progress: Callable[[float, str], None]) -> _Outcome:
    """Return a diagnosis that this process makes."""
    require_service()
    from modallab.api.from_files import Files, diagnose_files
    from modallab.diagnosis.reporting.heading import ReportHeading
    from modallab.diagnosis.reporting.report import report
    from modallab.diagnosis.reporting.summary import summary
    from modallab_cli.results import diagnosis_result

    files = Files(inputs.model, inputs.rig, inputs.measured, inputs.mesh)
    outcome = diagnose_files(files, inputs.request, averages=inputs.averages, progress=progress, warn=warn_of)
    origin = {"call": shlex.join(["modallab", *sys.argv[1:]]), "version": outcome.entry.version}
    return _Outcome(
        summary(outcome.diagnosis),
        outcome.json(),
        lambda: report(outcome.diagnosis, origin, ReportHeading(**inputs.heading)),
        lambda: diagnosis_result(outcome),
    )


def _at(server: str, inputs: _Inputs, progress: Callable[[float, str], None]) -> _Outcome:
    """Return a diagnosis that a lab has made."""
    with lab_of(server) as lab:
        structure = structure_of(lab, inputs.model, inputs.mesh)
        test = measurement_of(lab, inputs.measured, inputs.rig, inputs.averages)
        options: Any = inputs.request
        result = lab.diagnoses.start(structure.id, test.id, **options).result(progress)
        reply = lab.request("GET", f"/v1/diagnoses/{result.id}")
        heading: Any = inputs.heading
        page = lab.diagnoses.report(result.id, **heading)
    words = "\n\n".join([result.summary(), result.table(), *result.left_open()])
    return _Outcome(words, json.dumps(reply, indent=2), lambda: page, lambda: result)
