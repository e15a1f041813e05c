"""Commands that run the service, and the demo."""

import signal
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Any

import click

from modallab_cli.arguments import WRITTEN

data = click.option("--data", type=WRITTEN, help="Folder for arrays and the embedded database.")
executor_id = click.option(
    "--executor-id", help="A name among the processes that run jobs; else from host and process."
)


def _settings(**overrides: Any) -> Any:
    from pydantic import ValidationError

    from modallab.api.settings import ServiceSettings

    try:
        return ServiceSettings(**{name: value for name, value in overrides.items() if value is not None})
    except ValidationError as error:
        fault = error.errors()[0]
        raise click.BadParameter(f"{'.'.join(map(str, fault['loc']))}: {fault['msg']}") from None


def _lock(folder: Path) -> sqlite3.Connection:
    """Return the lock of a data folder; this process holds it until it ends."""
    folder.mkdir(parents=True, exist_ok=True)
    lock = sqlite3.connect(folder / "lock", isolation_level=None, timeout=0)
    try:
        lock.execute("BEGIN EXCLUSIVE")
    except sqlite3.OperationalError:
        raise click.BadParameter(f"another service works in {folder}", param_hint="--data") from None
    return lock


def _need_postgresql(settings: Any) -> None:
    if settings.embedded:
        raise click.BadParameter("several processes share a PostgreSQL: set MODALLAB_DATABASE_URL")


def _prepare(settings: Any) -> None:
    settings.store_place.prepare()
    settings.job_place.prepare()


@click.command()
@data
@click.option("--host", help="Address to listen on.")
@click.option("--port", type=int, help="Port to listen on.")
@click.option("--role", help="`all`, or `api`: leave the jobs to `modallab worker`.")
@executor_id
def serve(**options: Any) -> None:
    """Answer requests and, unless the role is `api`, run jobs."""
    settings = _settings(**options)
    if settings.role == "api":
        _need_postgresql(settings)
    import uvicorn

    from modallab.api import logs
    from modallab.api.app import create_app

    logs.configure()
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


@click.command()
@data
@executor_id
def worker(data: Path | None, executor_id: str | None) -> None:
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
        raise click.BadParameter(str(error), param_hint="--executor-id") from None


@click.command()
@data
def init(data: Path | None) -> None:
    """Create the tables, or bring them up to date: once before the service is started or upgraded."""
    _prepare(_settings(data=data))


@click.command()
@click.option(
    "--seed",
    type=click.IntRange(0),
    default=4,
    show_default=True,
    help="Of noise and hidden effect.",
)
@click.option("--out", type=WRITTEN, default="demo-out", show_default=True, help="Folder for the page.")
def demo(seed: int, out: Path) -> None:
    """Measure, update and diagnose the beam of the 1992 thesis, over HTTP with a service of its own."""
    # A program of its own: it is a client, and meets the service on the wire only.
    command = [sys.executable, "-m", "modallab_client.demo", "--seed", str(seed), "--out", str(out)]
    raise click.exceptions.Exit(subprocess.call(command))
