"""Correlations: how the modes of a test and of a model agree."""

from modallab_client import _wire, _wire_findings
from modallab_client._sync.shelf import Shelf
from modallab_client.findings import Correlation


class Correlations(Shelf):
    """Correlations on the service."""

    path = "/v1/correlations"

    def create(self, modal_model_id: str, structure_id: str, *, count: int | None = None) -> Correlation:
        """Return MAC, pairs, frequency differences and CoMAC of measured against computed modes.

        Parameters
        ----------
        modal_model_id, structure_id
            The measured modes and the model.
        count
            Elastic modes of the model; left out: as many as were measured.
        """
        body = _wire.body(modal_model_id=modal_model_id, structure_id=structure_id, count=count)
        return _wire.read(_wire_findings.correlation, self._transport.request("POST", self.path, json=body))

    def get(self, correlation_id: str) -> Correlation:
        """Return a correlation."""
        reply = self._transport.request("GET", f"{self.path}/{correlation_id}")
        return _wire.read(_wire_findings.correlation, reply)
