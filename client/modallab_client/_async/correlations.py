"""Correlations: how the modes of a test and of a model agree."""

from modallab_client import _wire, _wire_findings
from modallab_client._async.transport import AsyncTransport
from modallab_client.findings import Correlation


class AsyncCorrelations:
    """Correlations on the service."""

    def __init__(self, transport: AsyncTransport) -> None:
        self._transport = transport

    async def create(self, modal_model_id: str, structure_id: str) -> Correlation:
        """Return MAC, pairs, frequency differences and CoMAC of measured against computed modes."""
        body = {"modal_model_id": modal_model_id, "structure_id": structure_id}
        reply = await self._transport.request("POST", "/v1/correlations", json=body)
        return _wire.read(_wire_findings.correlation, reply)
