"""Catalogue of names that can be chosen, with units and bounds."""

from modallab_client import _wire
from modallab_client._async.transport import AsyncTransport
from modallab_client.results import CatalogueEntry


class AsyncCatalog:
    """The families of the service; each call returns its members."""

    def __init__(self, transport: AsyncTransport) -> None:
        self._transport = transport

    async def effects(self) -> tuple[CatalogueEntry, ...]:
        """Return the kinds of effects."""
        return await self._family("effects")

    async def structures(self) -> tuple[CatalogueEntry, ...]:
        """Return the ready structures."""
        return await self._family("structures")

    async def excitations(self) -> tuple[CatalogueEntry, ...]:
        """Return the kinds of excitation."""
        return await self._family("excitations")

    async def windows(self) -> tuple[CatalogueEntry, ...]:
        """Return the windows of the analyser."""
        return await self._family("windows")

    async def estimators(self) -> tuple[CatalogueEntry, ...]:
        """Return the FRF estimators."""
        return await self._family("estimators")

    async def extraction_methods(self) -> tuple[CatalogueEntry, ...]:
        """Return the methods that extract modes."""
        return await self._family("extraction-methods")

    async def updating_methods(self) -> tuple[CatalogueEntry, ...]:
        """Return the methods that update a model."""
        return await self._family("updating-methods")

    async def reductions(self) -> tuple[CatalogueEntry, ...]:
        """Return the reductions of all degrees of freedom to master degrees of freedom."""
        return await self._family("reductions")

    async def _family(self, name: str) -> tuple[CatalogueEntry, ...]:
        return _wire.read(_wire.catalogue, await self._transport.request("GET", f"/v1/catalog/{name}"))
