"""The gate before `/v1`: names the sender of a request, or refuses it before its body is read.

With keys, a request is its key's, or that of the session in its cookie. Without keys everybody is let in who
reaches the service, but no web page of another origin: neither by a name that its own domain server gives
this machine (`Host`), nor by a request that a browser says comes from elsewhere (`Origin`, `Sec-Fetch-Site`).
"""

import hmac
from collections.abc import Collection
from functools import partial
from urllib.parse import urlsplit

import sqlalchemy as sa
import structlog
from anyio import to_thread
from pydantic import SecretStr
from sqlalchemy.exc import DBAPIError
from starlette.datastructures import Headers
from starlette.requests import Request, cookie_parser
from starlette.types import ASGIApp, Receive, Scope, Send

from modallab.api import problems
from modallab.api.access import WITHOUT_KEYS, Caller
from modallab.core.errors import ModalLabError
from modallab.store.base import ForbiddenError, UnauthorisedError
from modallab.store.keys import Key, KeyBook
from modallab.store.sessions import SessionBook

PREFIX = "/v1/"
_GUARDED = (PREFIX, "/metrics")
OPEN_TO_ALL = frozenset(
    {("GET", f"/v1/{name}") for name in ("health", "ready", "version")} | {("POST", "/v1/sessions")}
)
COOKIE = "modallab_session"
_READING = ("GET", "HEAD", "OPTIONS")


class Gate:
    """Names the caller of every request that is not for a page or the document of the API.

    Parameters
    ----------
    engine
        Of the store's database.
    allowed_hosts
        Names by which a service without keys is asked for; None: any.
    embedding_key
        Of the program that embeds the service; None: none does.
    """

    def __init__(
        self,
        app: ASGIApp,
        *,
        engine: sa.Engine,
        allowed_hosts: Collection[str] | None,
        embedding_key: SecretStr | None = None,
    ) -> None:
        self._app, self._allowed_hosts = app, allowed_hosts
        self._embedding_key = embedding_key
        self._keys, self._sessions = KeyBook(engine), SessionBook(engine)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle an ASGI request."""
        if scope["type"] != "http" or not scope["path"].startswith(_GUARDED):
            await self._app(scope, receive, send)
            return
        state = scope.setdefault("state", {})
        try:
            caller = await self._caller(scope)
        except (ModalLabError, DBAPIError, sa.exc.TimeoutError, OSError) as error:
            await problems.reply_to(Request(scope), error)(scope, receive, send)
            return
        if caller is None:
            await self._app(scope, receive, send)
            return
        state |= {"caller": caller, "verify": partial(self._caller, scope)}
        with structlog.contextvars.bound_contextvars(owner=caller.viewer.owner):
            await self._app(scope, receive, send)

    async def _caller(self, scope: Scope) -> Caller | None:
        """Return who sends a request; None where that does not matter."""
        headers, method = Headers(scope=scope), scope["method"]
        key_text = bearer(headers)
        if key_text is None and method not in _READING:
            _check_origin(headers)
        if (method, scope["path"]) in OPEN_TO_ALL:
            return None
        return await to_thread.run_sync(self._named, headers, key_text)

    def _named(self, headers: Headers, key_text: str | None) -> Caller:
        if not self._keys.exists():
            self._check_host(headers)
            return WITHOUT_KEYS
        if self._is_embedding(key_text):
            return WITHOUT_KEYS
        key = self._key(headers, key_text)
        return Caller(key.viewer, key)

    def _is_embedding(self, key_text: str | None) -> bool:
        """Return whether the program that embeds the service sent this key."""
        if self._embedding_key is None or key_text is None:
            return False
        return hmac.compare_digest(self._embedding_key.get_secret_value().encode(), key_text.encode())

    def _key(self, headers: Headers, key_text: str | None) -> Key:
        if key_text is not None:
            return self._keys.verified(key_text)
        cookie = session_cookie(headers)
        if cookie is not None:
            return self._sessions.key(cookie)
        raise UnauthorisedError("a key is needed, in the header `Authorization: Bearer KEY`")

    def _check_host(self, headers: Headers) -> None:
        host = headers.get("host", "")
        if self._allowed_hosts is not None and _without_port(host) not in self._allowed_hosts:
            raise ForbiddenError(
                "without keys the service has these names only; MODALLAB_ALLOWED_HOSTS adds others",
                field="Host",
                value=host,
                allowed=sorted(self._allowed_hosts),
            )


def session_cookie(headers: Headers) -> str | None:
    """Return the cookie of a session; None if there is none."""
    return cookie_parser(headers.get("cookie", "")).get(COOKIE)


def bearer(headers: Headers) -> str | None:
    """Return the key of the header `Authorization`; None if there is none."""
    scheme, _, text = headers.get("authorization", "").partition(" ")
    return text.strip() if scheme.lower() == "bearer" else None


def _without_port(host: str) -> str:
    name, _, port = host.rpartition(":")
    return (name if port.isdecimal() else host).lower()


def _check_origin(headers: Headers) -> None:
    """Raise `ForbiddenError` for what a browser sends on behalf of another origin's page.

    Browsers set these headers themselves; other programs send none. Old browsers send `Origin` alone.
    """
    site, origin = headers.get("sec-fetch-site"), headers.get("origin")
    is_foreign = (
        site not in ("same-origin", "none")
        if site is not None
        else origin is not None and urlsplit(origin).netloc != headers.get("host", "")
    )
    if is_foreign:
        raise ForbiddenError(
            "web pages of other origins may not change anything here",
            field="Origin",
            value=origin,
            allowed="the origin of the service",
        )
