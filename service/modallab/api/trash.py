"""Trash: what was deleted, to be restored within a day."""

from typing import Any

from fastapi import APIRouter, status

from modallab.api.deps import After, IdPath, Limit, OwnerDep, OwnerWanted, StoreDep
from modallab.api.wire import Reply, StoredEntry

router = APIRouter(prefix="/trash", tags=["trash"])


class DiscardedEntry(StoredEntry):
    """Entry of something in the trash."""

    kind: str
    """`structure`, `rig`, `measurement`, `modal_model`, `correlation`, `update`, `study` or `diagnosis`"""
    removed: str
    """time at which it was deleted, ISO 8601, UTC"""
    until: str
    """time until which it can be restored, ISO 8601, UTC"""


class TrashPage(Reply):
    """Page of the list of what is in the trash."""

    items: list[DiscardedEntry]
    """Entries, last deleted first."""
    next: str | None
    """Value of `after` for the next page; null at the end."""


@router.get("", response_model=TrashPage, summary="List the trash")
def list_trash(
    store: StoreDep, own: OwnerDep, owner: OwnerWanted = None, limit: Limit = 100, after: After = None
) -> Any:
    """Return what was deleted and can be restored: the caller's own, or that of another `owner`."""
    found = store.trash.list(owner=own if owner is None else owner, limit=limit, cursor=after)
    items = [
        DiscardedEntry(
            **StoredEntry.fields(thing.entry),
            kind=thing.entry.kind,
            removed=thing.removed,
            until=thing.until,
        )
        for thing in found
    ]
    return TrashPage(items=items, next=items[-1].id if len(items) == limit else None)


@router.post("/{id}/restore", response_model=StoredEntry, summary="Restore from the trash")
def restore_from_trash(id: IdPath, store: StoreDep) -> Any:
    """Return the entry of what is taken out of the trash; it has its id, name and shares as before.

    Refused (409) while what it was made from is in the trash.
    """
    return StoredEntry(**StoredEntry.fields(store.trash.restore(id)))


@router.delete("/{id}", status_code=status.HTTP_204_NO_CONTENT, summary="Remove from the trash for good")
def remove_from_trash(id: IdPath, store: StoreDep) -> None:
    """Remove something in the trash for good; refused (409) while another in the trash was made from it."""
    store.trash.remove(id)
