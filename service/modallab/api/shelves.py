"""List and removal of the entries of a resource."""

from fastapi import APIRouter, status

from modallab.api.deps import After, IdPath, Limit, OwnerWanted, StoreDep
from modallab.api.wire import Reply, StoredEntry
from modallab.store.base import Shelf, Store


class Page(Reply):
    """Page of a list of stored objects."""

    items: list[StoredEntry]
    """Entries, newest first."""
    next: str | None
    """Value of `after` for the next page; null at the end."""


def add_routes(router: APIRouter, shelf: str, singular: str) -> None:
    """Add the list and the removal of entries on one of the store's shelves.

    Added last: their paths must not shadow the resource's own.

    Parameters
    ----------
    shelf
        Attribute of the store, the resource's name in the plural.
    singular
        The resource's name in the singular.
    """
    plural, thing = shelf.replace("_", " "), singular.replace("_", " ")

    def of(store: Store) -> Shelf[object]:
        entries: Shelf[object] = getattr(store, shelf)
        return entries

    @router.get(
        "",
        name=f"list_{shelf}",
        summary=f"List {plural}",
        description=f"Return the stored {plural} page by page, newest first.",
    )
    def list_entries(
        store: StoreDep, owner: OwnerWanted = None, limit: Limit = 100, after: After = None
    ) -> Page:
        entries = of(store).list(owner=owner, limit=limit, cursor=after)
        items = [StoredEntry(**StoredEntry.fields(entry)) for entry in entries]
        return Page(items=items, next=items[-1].id if len(items) == limit else None)

    @router.delete(
        "/{id}",
        name=f"delete_{singular}",
        status_code=status.HTTP_204_NO_CONTENT,
        summary=f"Delete a {thing}",
        description=f"Delete a stored {thing}; refused (409) while another result was made from it.",
    )
    def remove_entry(id: IdPath, store: StoreDep) -> None:
        of(store).remove(id)
