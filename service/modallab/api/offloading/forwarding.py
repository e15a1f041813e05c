"""What goes to a worker process, and what comes back: requests and replies as plain values and files."""

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import structlog
from starlette.background import BackgroundTask
from starlette.requests import Request
from starlette.responses import FileResponse, Response

from modallab.api.logs import OFFLOADED
from modallab.api.offloading.settings import OFFLOADING

BODY, REPLY = "body", "reply"
_SCOPE = ("type", "http_version", "method", "path", "raw_path", "query_string", "root_path", "scheme")
_MADE_ANEW = ("content-length", "x-request-id")


@dataclass(frozen=True)
class Forwarded:
    """A request as it goes to a worker process."""

    scope: Mapping[str, Any]
    """ASGI scope, plain values only."""
    folder: Path
    """Folder with the body as a file, and for the body of the reply."""


@dataclass(frozen=True)
class Answered:
    """A reply as it comes from a worker process, its body in the folder of the request."""

    status: int
    """HTTP status."""
    headers: Mapping[str, str]
    """Headers of the reply."""


async def forwarded(request: Request, folder: Path) -> Forwarded:
    """Return a request for a worker process, its body written into a folder."""
    with (folder / BODY).open("wb") as body:  # pieces of some kilobytes, into the system's cache
        async for chunk in request.stream():
            body.write(chunk)
    own_id = str(structlog.contextvars.get_contextvars().get("request", ""))
    headers = [(name, value) for name, value in request.scope["headers"] if name != b"x-request-id"]
    scope = {name: request.scope.get(name) for name in (*_SCOPE, "client", "server")}
    made = {
        "asgi": {"version": "3.0"},
        OFFLOADED: True,
        "headers": [*headers, (b"x-request-id", own_id.encode())],
    }
    return Forwarded({**scope, **made}, folder)


def reply_of(answered: Answered, folder: Path) -> Response:
    """Return the reply that a worker process wrote into a folder, and have the folder removed."""
    headers = {name: value for name, value in answered.headers.items() if name not in _MADE_ANEW}
    if (folder / REPLY).stat().st_size > OFFLOADING.chunk_bytes:
        media_type = headers.pop("content-type", None)
        removal = BackgroundTask(remove, folder)
        return FileResponse(folder / REPLY, answered.status, headers, media_type, removal)
    content = (folder / REPLY).read_bytes()
    remove(folder)
    return Response(content, answered.status, headers)


def remove(folder: Path) -> None:
    """Remove a folder with what is in it."""
    shutil.rmtree(folder, ignore_errors=True)
