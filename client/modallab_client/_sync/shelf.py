"""List and removal of stored things of one kind."""

from collections.abc import Sequence
from typing import ClassVar

from modallab_client import _wire
from modallab_client._generated.models import Page
from modallab_client._sync.pages import all_items
from modallab_client._sync.transport import Transport
from modallab_client.results import StoredEntry
from modallab_client.stored import Identified, id_of


class Shelf:
    """Stored things of one kind."""

    path: ClassVar[str]

    def __init__(self, transport: Transport) -> None:
        self._transport = transport

    def list(
        self, *, name: str | None = None, label: str | None = None, owner: str | None = None
    ) -> tuple[StoredEntry, ...]:
        """Return the entries of stored things, newest first, without content.

        Parameters
        ----------
        name
            Part of the name, in capitals or not.
        label
            One of the labels.
        owner
            Id of the key that made them.
        """
        return all_items(self._transport, self.path, Page, name=name, label=label, owner=owner)

    def describe(
        self,
        id: Identified,
        *,
        name: str | None = None,
        labels: Sequence[str] | None = None,
        comment: str | None = None,
    ) -> StoredEntry:
        """Return the entry of one with a new name, labels or comment; what is left out stays."""
        body = _wire.body(name=name, labels=None if labels is None else list(labels), comment=comment)
        reply = self._transport.request("PATCH", f"{self.path}/{id_of(id)}", json=body)
        return _wire.read(_wire.entry, reply)

    def delete(self, id: Identified) -> None:
        """Move one to the trash; what others were made from stays, with a `ConflictError`."""
        self._transport.request("DELETE", f"{self.path}/{id_of(id)}")
