"""Catalogue of names that can be chosen, with units and bounds."""

from modallab_client import _wire
from modallab_client._sync.transport import Transport
from modallab_client.results import CatalogueEntry


class Catalog:
    """The families of the service; each call returns its members."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport

    def effects(self) -> tuple[CatalogueEntry, ...]:
        """Return the kinds of effects."""
        return self._family("effects")

    def structures(self) -> tuple[CatalogueEntry, ...]:
        """Return the ready structures."""
        return self._family("structures")

    def excitations(self) -> tuple[CatalogueEntry, ...]:
        """Return the kinds of excitation."""
        return self._family("excitations")

    def windows(self) -> tuple[CatalogueEntry, ...]:
        """Return the windows of the analyser."""
        return self._family("windows")

    def estimators(self) -> tuple[CatalogueEntry, ...]:
        """Return the FRF estimators."""
        return self._family("estimators")

    def extraction_methods(self) -> tuple[CatalogueEntry, ...]:
        """Return the methods that extract modes."""
        return self._family("extraction-methods")

    def updating_methods(self) -> tuple[CatalogueEntry, ...]:
        """Return the methods that update a model."""
        return self._family("updating-methods")

    def reductions(self) -> tuple[CatalogueEntry, ...]:
        """Return the reductions of all degrees of freedom to master degrees of freedom."""
        return self._family("reductions")

    def _family(self, name: str) -> tuple[CatalogueEntry, ...]:
        return _wire.read(_wire.catalogue, self._transport.request("GET", f"/v1/catalog/{name}"))
