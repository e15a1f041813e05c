"""Commands that run the service, and the demo."""

import signal
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

Data = Annotated[Path | None, typer.Option(help="Folder for arrays and the embedded database.")]
Host = Annotated[str | None, typer.Option(help="Address to listen on.")]
Port = Annotated[int | None, typer.Option(help="Port to listen on.")]
Role = Annotated[str | None, typer.Option(help="`all`, or `api`: leave the jobs to `modallab worker`.")]
Executor = Annotated[
    str | None, typer.Option(help="A name among the processes that run jobs; else from host and process.")
]


def _settings(**overrides: Any) -> Any:
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


def init(data: Data = None) -> None:
    """Create the tables, or bring them up to date: once before the service is started or upgraded."""
    _prepare(_settings(data=data))


def demo(
    seed: Annotated[int, typer.Option(min=0, help="Draws the noise and the hidden effect.")] = 4,
    out: Annotated[Path, typer.Option(help="Folder for the page.")] = Path("demo-out"),
) -> None:
    """Measure, update and diagnose the beam of the 1992 thesis, over HTTP with a service of its own."""
    # A program of its own: it is a client, and meets the service on the wire only.
    command = [sys.executable, "-m", "modallab_client.demo", "--seed", str(seed), "--out", str(out)]
    raise typer.Exit(subprocess.call(command))
