"""Commands that run the service, and the demo."""

import gc
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import click

from modallab_cli.arguments import WRITTEN
from modallab_cli.settings import settings_of

# s: longer than clients keep a connection that they do not use, httpx for 5 s. Were it as long, one would
# send a request while the service closes the connection.
_IDLE = 15

data = click.option("--data", type=WRITTEN, help="Folder for arrays and the embedded database.")
executor_id = click.option(
    "--executor-id", help="A name among the processes that run jobs; else from host and process."
)


@contextmanager
def _without_garbage_collection() -> Iterator[None]:
    """Suspend garbage collection, which takes a fifth of the time of imports and finds next to nothing."""
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def _need_postgresql(settings: Any) -> None:
    if settings.embedded:
        raise click.BadParameter("several processes share a PostgreSQL: set MODALLAB_DATABASE_URL")


def _prepare(settings: Any) -> None:
    from modallab_cli.starting import prepare

    prepare(settings)


def _need_keys(settings: Any) -> None:
    """Refuse to listen to others than this machine without keys."""
    from modallab.store.keys import KeyBook
    from modallab.store.place import engine_of

    if settings.is_loopback or settings.open or KeyBook(engine_of(settings.store_place)).exists():
        return
    raise click.BadParameter(
        f"others reach {settings.host}, and there are no keys: make the first with `modallab keys create "
        "--role admin --name NAME`, or let everybody in with --open",
        param_hint="--host",
    )


def _address(host: str, port: int) -> str:
    """Return the address to open in a browser; a service for all of a network is on this machine, too."""
    name = {"0.0.0.0": "localhost", "::": "localhost"}.get(host, f"[{host}]" if ":" in host else host)
    return f"http://{name}:{port}/"


@click.command()
@data
@click.option("--host", help="Address to listen on.")
@click.option("--port", type=int, help="Port to listen on.")
@click.option(
    "--open",
    is_flag=True,
    default=None,
    help="Answer everybody on an address that others reach, without keys.",
)
@click.option("--role", help="`all`, or `api`: leave the jobs to `modallab worker`.")
@executor_id
def serve(**options: Any) -> None:
    """Answer requests and, unless the role is `api`, run jobs."""
    settings = settings_of(**options)
    if settings.role == "api":
        _need_postgresql(settings)
    with _without_garbage_collection():
        import uvicorn

        from modallab.api import logs
        from modallab.api.allocator import share_arenas
        from modallab.api.app import create_app
        from modallab.api.offloading.processes import RequestProcesses
        from modallab_cli.starting import lock_of

    logs.configure()
    share_arenas()
    lock = lock_of(settings.data) if settings.embedded else None
    if settings.embedded:
        _prepare(settings)
    _need_keys(settings)
    click.echo(f"The laboratory opens at {_address(settings.host, settings.port)}", err=True)
    uvicorn.run(
        create_app(settings, processes=RequestProcesses(settings)),
        host=settings.host,
        port=settings.port,
        log_config=None,
        access_log=False,
        timeout_graceful_shutdown=5,
        timeout_keep_alive=_IDLE,
    )
    del lock


@click.command()
@data
@executor_id
def worker(data: Path | None, executor_id: str | None) -> None:
    """Run jobs, and answer no requests."""
    settings = settings_of(data=data, executor_id=executor_id, role="all")
    _need_postgresql(settings)
    with _without_garbage_collection():
        import anyio

        from modallab.api import logs
        from modallab.api.runners import durable_runner
        from modallab.jobs.executors import ExecutorTakenError

    logs.configure()

    async def work() -> None:
        async with durable_runner(settings):
            with anyio.open_signal_receiver(signal.SIGTERM, signal.SIGINT) as signals:
                async for _ in signals:
                    _end_at_last()
                    return  # jobs under way go back to the queue

    try:
        anyio.run(work)
    except ExecutorTakenError as error:
        raise click.BadParameter(str(error), param_hint="--executor-id") from None


def _end_at_last() -> None:
    """End this process after a while even if the engine's threads wait for a database that is away."""
    import psutil

    from modallab.jobs.settings import JOB

    def end() -> None:
        for child in psutil.Process().children(recursive=True):
            with suppress(psutil.NoSuchProcess):
                child.kill()
        os._exit(1)

    timer = threading.Timer(JOB.longest_end, end)
    timer.daemon = True
    timer.start()


@click.command()
@data
def init(data: Path | None) -> None:
    """Create the tables, or bring them up to date: once before the service is started or upgraded."""
    _prepare(settings_of(data=data))


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
