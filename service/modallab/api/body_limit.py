"""Refuses bodies that are too large before they are read."""

from typing import Any

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from modallab.api import problems


class BodyLimit:
    """Answers 413 as soon as a request announces, or has sent, more than it may.

    FastAPI's own limit answers in plain text; this one sends a problem document.
    """

    def __init__(self, app: ASGIApp, *, json: int, upload: int) -> None:
        self._app, self._json, self._upload = app, json, upload

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle an ASGI request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        # By its address, too: any client may call any body a form.
        form = headers.get("content-type", "").startswith("multipart/form-data")
        upload = form and scope["path"].endswith("/import")
        limit = self._upload if upload else self._json
        announced = headers.get("content-length", "")
        if announced.isdecimal() and int(announced) > limit:
            await problems.response(_too_large(limit))(scope, receive, send)
            return
        n_bytes = 0

        async def receive_counted() -> Message:
            nonlocal n_bytes
            message = await receive()
            n_bytes += len(message.get("body", b""))
            if n_bytes > limit:  # sent in chunks, with no length announced
                raise HTTPException(413, _too_large(limit)["detail"])
            return message

        await self._app(scope, receive_counted, send)


def _too_large(limit: int) -> dict[str, Any]:
    detail = f"the body is larger than {limit} bytes"
    return problems.document(413, "content_too_large", detail, {"allowed": limit})
