"""The verbs that every resource has."""

from fastapi import APIRouter, status
from pydantic import BaseModel

from modallab.api.deps import After, IdPath, Limit, OwnerDep, StoreDep
from modallab.api.wire import EntryOut
from modallab.store.base import Shelf, Store


class PageOut(BaseModel):
    """Entries, newest first; `next` is the `after` of the next page."""

    items: list[EntryOut]
    next: str | None


def add_routes(router: APIRouter, shelf: str) -> None:
    """Add the list and the removal of things on one of the store's shelves.

    Added last: their paths must not shadow the resource's own.
    """

    def of(store: Store) -> Shelf[object]:
        found: Shelf[object] = getattr(store, shelf)
        return found

    @router.get("", summary="List, newest first")
    def list_things(store: StoreDep, owner: OwnerDep, limit: Limit = 100, after: After = None) -> PageOut:
        entries = of(store).list(owner=owner, limit=limit, after=after)
        items = [EntryOut(**EntryOut.fields(entry)) for entry in entries]
        return PageOut(items=items, next=items[-1].id if len(items) == limit else None)

    @router.delete("/{id}", status_code=status.HTTP_204_NO_CONTENT, summary="Remove, unless it is in use")
    def remove_thing(id: IdPath, store: StoreDep) -> None:
        of(store).remove(id)
