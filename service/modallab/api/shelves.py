"""List and removal of the entries of a resource."""

from typing import Annotated

from fastapi import APIRouter, Query, status
from pydantic import Field, StringConstraints

from modallab.api.deps import After, IdPath, Limit, OwnerWanted, StoreDep
from modallab.api.examples import example
from modallab.api.wire import Reply, StoredEntry, Text, Wire
from modallab.store.base import Description, Shelf, Store

Label = Annotated[str, StringConstraints(min_length=1, max_length=50, pattern=r"^[^\x00-\x1f]+$")]
NamePart = Annotated[
    Text | None, Query(description="part of the name, in capitals or not; left out: any name")
]
LabelWanted = Annotated[Label | None, Query(description="label of the entries; left out: any")]
_DESCRIPTION = {"name": "first test", "labels": ["autumn", "group 3"], "comment": "the stinger was bent"}


class DescriptionIn(Wire):
    """What an owner says of a stored object; a field that is left out stays as it was."""

    name: Text | None = None
    """name"""
    labels: list[Label] | None = Field(default=None, max_length=20)
    """labels by which it is found"""
    comment: str | None = Field(default=None, max_length=2000, pattern=r"^[^\x00]*$")
    """remark"""


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
        store: StoreDep,
        owner: OwnerWanted = None,
        name: NamePart = None,
        label: LabelWanted = None,
        limit: Limit = 100,
        after: After = None,
    ) -> Page:
        entries = of(store).list(owner=owner, name=name, label=label, limit=limit, cursor=after)
        items = [StoredEntry(**StoredEntry.fields(entry)) for entry in entries]
        return Page(items=items, next=items[-1].id if len(items) == limit else None)

    @router.patch(
        "/{id}",
        name=f"describe_{singular}",
        summary=f"Describe a {thing}",
        description=f"Return the entry of a {thing} with a new name, labels or comment.",
    )
    def describe_entry(
        id: IdPath, body: Annotated[DescriptionIn, example(_DESCRIPTION)], store: StoreDep
    ) -> StoredEntry:
        of(store).describe(id, Description(body.name, body.labels, body.comment))
        return StoredEntry(**StoredEntry.fields(of(store).entry(id)))

    @router.delete(
        "/{id}",
        name=f"delete_{singular}",
        status_code=status.HTTP_204_NO_CONTENT,
        summary=f"Delete a {thing}",
        description=f"Move a stored {thing} to the trash, where it can be restored within 24 hours; refused "
        "(409) while another result was made from it.",
    )
    def remove_entry(id: IdPath, store: StoreDep) -> None:
        of(store).discard(id)
