"""Correlations: how the modes of a test and of a model agree."""

from modallab_client import _wire, _wire_findings
from modallab_client._async.shelf import AsyncShelf
from modallab_client.findings import Correlation


class AsyncCorrelations(AsyncShelf):
    """Correlations on the service."""

    path = "/v1/correlations"

    async def create(
        self, modal_model_id: str, structure_id: str, *, count: int | None = None
    ) -> Correlation:
        """Return MAC, pairs, frequency differences and CoMAC of measured against computed modes.

        Parameters
        ----------
        modal_model_id, structure_id
            The measured modes and the model.
        count
            Elastic modes of the model; left out: as many as were measured.
        """
        body = _wire.body(modal_model_id=modal_model_id, structure_id=structure_id, count=count)
        return _wire.read(
            _wire_findings.correlation, await self._transport.request("POST", self.path, json=body)
        )

    async def get(self, correlation_id: str) -> Correlation:
        """Return a correlation."""
        reply = await self._transport.request("GET", f"{self.path}/{correlation_id}")
        return _wire.read(_wire_findings.correlation, reply)
