"""The application in a worker process: what answers a heavy request, within limits of memory.

Request and reply travel as plain values, their bodies as files in a folder that the service removes.
"""

import os
from functools import lru_cache

import anyio
import structlog
from starlette.types import ASGIApp, Message

from modallab.api.allocator import return_memory_at_once
from modallab.api.offloading.confinement import OUT_OF_MEMORY, confined, end_process
from modallab.api.offloading.forwarding import BODY, REPLY, Answered, Forwarded
from modallab.api.offloading.settings import OFFLOADING
from modallab.api.settings import ServiceSettings

FOLDER = "modallab.folder"  # key of the scope: where the files of a request are


@lru_cache(maxsize=2)
def _application(settings: ServiceSettings) -> ASGIApp:
    # Here and not above: the service imports this file too, and is imported by the application.
    from modallab.api import logs
    from modallab.api.app import create_app

    # A worker process of anyio has no `sys.stderr`.
    logs.configure(os.fdopen(2, "w", buffering=1, closefd=False))
    return_memory_at_once()
    app = create_app(settings)
    app.add_exception_handler(
        MemoryError, lambda request, _error: end_process(request.scope[FOLDER], OUT_OF_MEMORY)
    )
    return app


def prepare(settings: ServiceSettings) -> None:
    """Load the application, which takes a second; nothing happens the next time."""
    _application(settings)


def answer(settings: ServiceSettings, request: Forwarded) -> Answered:
    """Return the reply to a request, its body written into the folder of the request.

    A module-level function of plain values, so that it can be sent to another process.
    """
    with confined(request.folder):
        return anyio.run(_answered, _application(settings), request)


async def _answered(app: ASGIApp, request: Forwarded) -> Answered:
    folder, started = request.folder, list[Message]()
    with (folder / BODY).open("rb") as body, (folder / REPLY).open("wb") as reply:

        async def receive() -> Message:
            chunk = body.read(OFFLOADING.chunk_bytes)
            return {
                "type": "http.request",
                "body": chunk,
                "more_body": len(chunk) == OFFLOADING.chunk_bytes,
            }

        async def send(message: Message) -> None:
            if message["type"] == "http.response.start":
                started.append(message)
            reply.write(message.get("body", b""))

        try:
            await app({**request.scope, FOLDER: folder}, receive, send)
        except Exception:
            # Starlette answers a fault first and raises it then, for the log of a server.
            if not started:
                raise
            structlog.get_logger().exception("unhandled", path=request.scope["path"])
    headers = {name.decode("latin-1"): value.decode("latin-1") for name, value in started[0]["headers"]}
    return Answered(started[0]["status"], headers)
