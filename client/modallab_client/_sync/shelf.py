"""List and removal of stored things of one kind."""

from typing import ClassVar

from modallab_client import _wire
from modallab_client._sync.transport import Transport
from modallab_client.results import StoredEntry
from modallab_client.stored import Identified, id_of


class Shelf:
    """Stored things of one kind."""

    path: ClassVar[str]

    def __init__(self, transport: Transport) -> None:
        self._transport = transport

    def list(self) -> tuple[StoredEntry, ...]:
        """Return the entries of stored things, newest first, without content."""
        collected: tuple[StoredEntry, ...] = ()
        cursor: str | None = None
        while True:
            reply = self._transport.request("GET", self.path, params=_wire.body(after=cursor))
            entries, cursor = _wire.read(_wire.page, reply)
            collected += entries
            if cursor is None:
                return collected

    def delete(self, id: Identified) -> None:
        """Remove one; things that others were made from stay, with a `ConflictError`."""
        self._transport.request("DELETE", f"{self.path}/{id_of(id)}")
