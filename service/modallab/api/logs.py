"""JSON logs, each line with the id of the request it belongs to."""

import logging
import re
import secrets
import time
from typing import TextIO

import structlog
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

OFFLOADED = "modallab.offloaded"  # in the scope of a request that another process handed over
_HEADER = "X-Request-Id"
_log = structlog.get_logger()
_SOUND = re.compile(r"[A-Za-z0-9._-]{1,64}")


def configure(stream: TextIO | None = None) -> None:
    """Send structlog and the standard library's loggers to a stream, by default standard error, as JSON."""
    processors: list[structlog.typing.Processor] = [
        structlog.contextvars.merge_contextvars,
        structlog.processors.add_log_level,
        structlog.processors.TimeStamper(fmt="iso", utc=True),
    ]
    structlog.configure(
        processors=[*processors, structlog.stdlib.ProcessorFormatter.wrap_for_formatter],
        logger_factory=structlog.stdlib.LoggerFactory(),
        cache_logger_on_first_use=True,
    )
    formatter = structlog.stdlib.ProcessorFormatter(
        foreign_pre_chain=processors,
        processors=[
            structlog.stdlib.ProcessorFormatter.remove_processors_meta,
            structlog.processors.format_exc_info,
            structlog.processors.JSONRenderer(),
        ],
    )
    handler = logging.StreamHandler(stream)
    handler.setFormatter(formatter)
    logging.basicConfig(handlers=[handler], level=logging.INFO, force=True)
    for talkative in ("alembic", "dbos"):
        logging.getLogger(talkative).setLevel(logging.WARNING)


class RequestId:
    """Gives every request an id, its own or ours, says it in the reply, and logs the request."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle an ASGI request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        header = Headers(scope=scope).get(_HEADER, "")
        request_id = header if _SOUND.fullmatch(header) else secrets.token_hex(8)
        begin, status = time.monotonic(), 500

        async def send_with_id(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                MutableHeaders(scope=message)[_HEADER] = request_id
            await send(message)

        with structlog.contextvars.bound_contextvars(request=request_id):
            try:
                await self._app(scope, receive, send_with_id)
            finally:
                if OFFLOADED not in scope:  # whoever offloaded the request says so itself
                    seconds = round(time.monotonic() - begin, 4)
                    _log.info(
                        "request", method=scope["method"], path=scope["path"], status=status, seconds=seconds
                    )
