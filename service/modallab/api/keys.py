"""API keys: made, listed, renewed, revoked."""

from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request, status
from pydantic import AwareDatetime
from starlette.responses import Response

from modallab.api.access import ADMIN_KEY, KeyDep
from modallab.api.deps import After, IdPath, Limit
from modallab.api.examples import example
from modallab.api.replies import reply
from modallab.api.wire import HolderName, Reply, Wire
from modallab.store.keys import Key, KeyBook, NewKey, Role
from modallab.store.sign_in_links import Link, LinkBook

router = APIRouter(prefix="/keys", tags=["keys"])

KeyReply: Any = reply(Key, "Key")
NewKeyReply: Any = reply(Key, "NewKey", key=(str, "The key itself, told this once."))
LinkReply: Any = reply(Link, "Link")
_ADMIN = {"name": "Physics laboratory", "role": "instructor", "expires": "2030-03-31T00:00:00Z"}


class KeyIn(Wire):
    """An API key to be made."""

    name: HolderName
    """name of the person or program that holds it"""
    role: Role
    """what the holder may do"""
    expires: AwareDatetime | None = None
    """first moment at which the key does not count; null: it never expires"""


class KeyPage(Reply):
    """Page of a list of keys."""

    items: list[KeyReply]
    """Keys, newest first."""
    next: str | None
    """Value of `after` for the next page; null at the end."""


async def _keys(request: Request) -> KeyBook:
    keys: KeyBook = request.app.state.keys
    return keys


async def _links(request: Request) -> LinkBook:
    links: LinkBook = request.app.state.links
    return links


KeysDep = Annotated[KeyBook, Depends(_keys)]
LinksDep = Annotated[LinkBook, Depends(_links)]


def key_reply(key: Key) -> Any:
    """Return the reply of a key."""
    return KeyReply.model_validate(vars(key))


def new_key_reply(new: NewKey) -> Any:
    """Return the reply of a new key, with its text."""
    return NewKeyReply.model_validate(vars(new.key) | {"key": new.text})


def keep_secret(response: Response) -> None:
    """Let nothing on the way keep a reply."""
    response.headers["Cache-Control"] = "no-store"


SECRET: Any = Depends(keep_secret)


@router.post(
    "",
    status_code=status.HTTP_201_CREATED,
    response_model=NewKeyReply,
    summary="Create a key",
    dependencies=[ADMIN_KEY, SECRET],
)
def create_key(body: Annotated[KeyIn, example(_ADMIN)], keys: KeysDep) -> Any:
    """Return a new key; its text is told once and stored nowhere. Only for administrators."""
    return new_key_reply(keys.create(body.name, body.role, expires=body.expires))


@router.get("", response_model=KeyPage, summary="List keys")
def list_keys(keys: KeysDep, key: KeyDep, limit: Limit = 100, after: After = None) -> KeyPage:
    """Return the caller's own key, with the keys of his classes, or all keys, page by page, newest first."""
    found = keys.list(viewer=key.viewer, limit=limit, cursor=after)
    return KeyPage(items=[key_reply(k) for k in found], next=found[-1].id if len(found) == limit else None)


@router.get("/{id}", response_model=KeyReply, summary="Get a key")
def get_key(id: IdPath, keys: KeysDep, key: KeyDep) -> Any:
    """Return what is known of a key: everything but the key itself."""
    return key_reply(keys.get(id, viewer=key.viewer))


@router.post(
    "/{id}/rotate",
    status_code=status.HTTP_201_CREATED,
    response_model=NewKeyReply,
    summary="Renew a key",
    dependencies=[SECRET],
)
def rotate_key(id: IdPath, keys: KeysDep, key: KeyDep) -> Any:
    """Return a key with a new text; the former text counts no more, and what was made with it stays."""
    return new_key_reply(keys.rotate(id, viewer=key.viewer))


@router.post(
    "/{id}/links",
    status_code=status.HTTP_201_CREATED,
    response_model=LinkReply,
    summary="Create a link",
    dependencies=[SECRET],
)
def create_link(id: IdPath, keys: KeysDep, links: LinksDep, key: KeyDep) -> Any:
    """Return a link to the page that signs the holder of a key in once, told once; the key stays as it is."""
    return LinkReply.model_validate(vars(links.create(keys.get(id, viewer=key.viewer))))


@router.delete("/{id}", status_code=status.HTTP_204_NO_CONTENT, summary="Revoke a key")
def revoke_key(id: IdPath, keys: KeysDep, key: KeyDep) -> None:
    """Revoke a key at once and for good; what was made with it stays."""
    keys.revoke(id, viewer=key.viewer)
