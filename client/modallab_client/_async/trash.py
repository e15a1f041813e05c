"""The trash: what was deleted, to be restored within a day."""

from modallab_client import _wire
from modallab_client._async.pages import all_items
from modallab_client._async.transport import AsyncTransport
from modallab_client._generated.models import TrashPage
from modallab_client.results import DiscardedEntry, StoredEntry
from modallab_client.stored import Identified, id_of


class AsyncTrash:
    """What was deleted from the service and can be restored."""

    def __init__(self, transport: AsyncTransport) -> None:
        self._transport = transport

    async def list(self, *, owner: str | None = None) -> tuple[DiscardedEntry, ...]:
        """Return the entries of what is in the trash, last deleted first.

        Parameters
        ----------
        owner
            Id of the key that made them; None: one's own.
        """
        return await all_items(self._transport, "/v1/trash", TrashPage, owner=owner)

    async def restore(self, id: Identified) -> StoredEntry:
        """Return the entry of something that is taken out of the trash.

        Raises
        ------
        ConflictError
            If what it was made from is in the trash, too.
        """
        reply = await self._transport.request("POST", f"/v1/trash/{id_of(id)}/restore")
        return _wire.read(_wire.entry, reply)

    async def remove(self, id: Identified) -> None:
        """Remove something in the trash for good."""
        await self._transport.request("DELETE", f"/v1/trash/{id_of(id)}")
