"""Sessions: a key exchanged for the cookie of a browser."""

from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request, status
from pydantic import Field
from starlette.responses import Response

from modallab.api.access import ANY_KEY, KeyDep
from modallab.api.examples import example
from modallab.api.gate import COOKIE, PREFIX, bearer, session_cookie
from modallab.api.keys import SECRET, KeyReply, KeysDep, LinksDep, key_reply
from modallab.api.wire import Wire
from modallab.store.base import UnauthorisedError
from modallab.store.sessions import LENGTH, SessionBook

router = APIRouter(prefix="/sessions", tags=["keys"])

_KEY = {"key": "modallab_5f0c31"}


class SessionIn(Wire):
    """Opening of a session."""

    key: str = Field(max_length=200)
    """key of whoever signs in"""


class SessionByLinkIn(Wire):
    """Opening of a session by a link."""

    link: str = Field(max_length=200)
    """what the link has behind `#once=`; it counts once"""


async def _sessions(request: Request) -> SessionBook:
    sessions: SessionBook = request.app.state.sessions
    return sessions


SessionsDep = Annotated[SessionBook, Depends(_sessions)]


@router.post(
    "",
    status_code=status.HTTP_201_CREATED,
    response_model=KeyReply,
    summary="Sign in",
    dependencies=[SECRET],
)
def create_session(
    request: Request,
    response: Response,
    keys: KeysDep,
    sessions: SessionsDep,
    links: LinksDep,
    body: Annotated[SessionIn | SessionByLinkIn | None, example(_KEY)] = None,
) -> Any:
    """Return whose key it is, with a cookie that stands for the key; for web pages.

    The key comes in the body, or in the header `Authorization`. A link does instead of a key, once.
    """
    if isinstance(body, SessionByLinkIn):
        key = links.used(body.link)
    else:
        text = bearer(request.headers) if body is None else body.key
        if text is None:
            raise UnauthorisedError(
                "a key is needed, in the body or in the header `Authorization: Bearer KEY`"
            )
        key = keys.verified(text)
    response.set_cookie(
        COOKIE,
        sessions.create(key).cookie,
        max_age=int(LENGTH.total_seconds()),
        path=PREFIX,
        secure=request.url.scheme == "https",
        httponly=True,
        samesite="strict",
    )
    return key_reply(key)


@router.get("", response_model=KeyReply, summary="Get who is signed in")
def get_session(key: KeyDep) -> Any:
    """Return whose key or session this request has."""
    return key_reply(key)


@router.delete("", status_code=status.HTTP_204_NO_CONTENT, summary="Sign out", dependencies=[ANY_KEY])
def delete_session(request: Request, response: Response, sessions: SessionsDep) -> None:
    """End the session of the cookie that is sent."""
    cookie = session_cookie(request.headers)
    if cookie is not None:
        sessions.end(cookie)
    response.delete_cookie(COOKIE, path=PREFIX, httponly=True, samesite="strict")
