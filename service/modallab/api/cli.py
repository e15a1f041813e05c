"""The `modallab` command: what starts the service."""

import os
import shlex
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from modallab.api.convert_command import convert
from modallab.api.flags import request_of, with_flags
from modallab.diagnosis.options import DiagnosisOptions

app = typer.Typer(
    no_args_is_help=True, add_completion=False, help="A virtual modal-testing lab as a service."
)

Data = Annotated[Path | None, typer.Option(help="Folder for arrays and the embedded database.")]
Host = Annotated[str | None, typer.Option(help="Address to listen on.")]
Port = Annotated[int | None, typer.Option(help="Port to listen on.")]
Role = Annotated[str | None, typer.Option(help="`all`, or `api`: leave the jobs to `modallab worker`.")]
Executor = Annotated[
    str | None, typer.Option(help="A name among the processes that run jobs; else from host and process.")
]

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def _file(text: str) -> Any:
    return typer.Option(exists=True, dir_okay=False, readable=True, help=text)


def _one_thread() -> None:
    # Before numpy is imported, here and in the worker processes, which inherit it: two threads a
    # process on cores that other processes keep busy cost three quarters of the throughput.
    for name in _THREADS:
        os.environ.setdefault(name, "1")


def _settings(**overrides: Any) -> Any:
    _one_thread()
    from pydantic import ValidationError

    from modallab.api.settings import ServiceSettings

    try:
        return ServiceSettings(**{name: value for name, value in overrides.items() if value is not None})
    except ValidationError as error:
        fault = error.errors()[0]
        raise typer.BadParameter(f"{'.'.join(map(str, fault['loc']))}: {fault['msg']}") from None


def _lock(folder: Path) -> sqlite3.Connection:
    """Return the lock of a data folder; this process holds it until it ends."""
    folder.mkdir(parents=True, exist_ok=True)
    lock = sqlite3.connect(folder / "lock", isolation_level=None, timeout=0)
    try:
        lock.execute("BEGIN EXCLUSIVE")
    except sqlite3.OperationalError:
        raise typer.BadParameter(f"another service works in {folder}", param_hint="--data") from None
    return lock


def _need_postgresql(settings: Any) -> None:
    if settings.embedded:
        raise typer.BadParameter("several processes share a PostgreSQL: set MODALLAB_DATABASE_URL")


def _prepare(settings: Any) -> None:
    settings.store_place.prepare()
    settings.job_place.prepare()


def _address(host: str, port: int) -> str:
    """Return the address to open in a browser; a service for all of a network is on this machine, too."""
    name = {"0.0.0.0": "localhost", "::": "localhost"}.get(host, f"[{host}]" if ":" in host else host)
    return f"http://{name}:{port}/"


@app.command()
def serve(
    data: Data = None,
    host: Host = None,
    port: Port = None,
    role: Role = None,
    executor_id: Executor = None,
) -> None:
    """Answer requests and, unless the role is `api`, run jobs."""
    settings = _settings(data=data, host=host, port=port, role=role, executor_id=executor_id)
    if settings.role == "api":
        _need_postgresql(settings)
    import uvicorn

    from modallab.api import logs
    from modallab.api.app import create_app

    logs.configure()
    typer.echo(f"The laboratory opens at {_address(settings.host, settings.port)}", err=True)
    lock = _lock(settings.data) if settings.embedded else None
    if settings.embedded:
        _prepare(settings)
    uvicorn.run(
        create_app(settings),
        host=settings.host,
        port=settings.port,
        log_config=None,
        access_log=False,
        timeout_graceful_shutdown=5,
    )
    del lock


@app.command()
def worker(data: Data = None, executor_id: Executor = None) -> None:
    """Run jobs, and answer no requests."""
    settings = _settings(data=data, executor_id=executor_id, role="all")
    _need_postgresql(settings)
    import anyio

    from modallab.api import logs
    from modallab.api.app import durable_runner
    from modallab.jobs.executors import ExecutorTakenError

    logs.configure()

    async def work() -> None:
        async with durable_runner(settings):
            with anyio.open_signal_receiver(signal.SIGTERM, signal.SIGINT) as signals:
                async for _ in signals:
                    return  # jobs under way go back to the queue

    try:
        anyio.run(work)
    except ExecutorTakenError as error:
        raise typer.BadParameter(str(error), param_hint="--executor-id") from None


@app.command()
def init(data: Data = None) -> None:
    """Create the tables, or bring them up to date: once before the service is started or upgraded."""
    _prepare(_settings(data=data))


def diagnose(
    model: Annotated[Path, _file("Body of POST /v1/structures, JSON.")],
    measured: Annotated[Path, _file("FRFs: universal file, npz, HDF5, or the thesis program's text.")],
    rig: Annotated[Path, _file("Body of POST /v1/rigs, JSON: the log book of the test.")],
    report: Annotated[
        Path | None, typer.Option(help="Write the report, one HTML page, to this file.")
    ] = None,
    averages: Annotated[
        float | None, typer.Option(help="Effective averages; default: the file's, or else the rig's.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the whole result as JSON.")] = False,
    **flags: Any,
) -> None:
    """Say what a model or a log book lacks to explain measured FRFs: what, where, how much, how sure.

    Ends with 0 whatever the verdict, and with 2 if a file or an option is at fault.
    """
    _one_thread()
    from modallab.api.from_files import Files, diagnose_files
    from modallab.core.errors import ModalLabError, sentence
    from modallab.diagnosis.reporting.report import report as page
    from modallab.diagnosis.reporting.summary import summary

    reporter = _ProgressLine()
    request = request_of(DiagnosisOptions, flags)
    try:
        outcome = diagnose_files(Files(model, rig, measured), request, averages=averages, progress=reporter)
    except ModalLabError as error:
        typer.echo(f"modallab diagnose: {sentence(error)}", err=True)
        raise typer.Exit(2) from None
    finally:
        reporter.end()
    typer.echo(outcome.json() if as_json else summary(outcome.diagnosis))
    if report is not None:
        origin = {"call": shlex.join(["modallab", *sys.argv[1:]]), "version": outcome.entry.version}
        report.write_text(page(outcome.diagnosis, origin), encoding="utf-8")
        typer.echo(f"The report: {report.resolve()}", err=as_json)


# Files have no rig that could run the proposed tests.
app.command()(with_flags(diagnose, DiagnosisOptions, without=("act",)))


class _ProgressLine:
    """Says how far the work is: on one line of a terminal, else on a line of its own every tenth."""

    def __init__(self) -> None:
        self._tenth = -1

    def __call__(self, fraction: float, message: str) -> None:
        line = f"{fraction:4.0%}  {message}"
        if sys.stderr.isatty():
            sys.stderr.write(f"\r\033[K{line}")
        elif int(10 * fraction) > self._tenth:
            self._tenth = int(10 * fraction)
            sys.stderr.write(f"{line}\n")
        sys.stderr.flush()

    def end(self) -> None:
        """Leave the line to what follows."""
        if sys.stderr.isatty():
            sys.stderr.write("\r\033[K")


app.command()(convert)


@app.command()
def demo(
    seed: Annotated[int, typer.Option(min=0, help="Draws the noise and the hidden effect.")] = 4,
    out: Annotated[Path, typer.Option(help="Folder for the page.")] = Path("demo-out"),
) -> None:
    """Measure, update and diagnose the beam of the 1992 thesis, over HTTP with a service of its own."""
    # A program of its own: it is a client, and meets the service on the wire only.
    command = [sys.executable, "-m", "modallab_client.demo", "--seed", str(seed), "--out", str(out)]
    raise typer.Exit(subprocess.call(command))
