"""Correlations: how modes and FRFs of a test and of a model agree."""

from collections.abc import Mapping, Sequence
from typing import Any

from modallab_client import _wire
from modallab_client._sync.shelf import Shelf
from modallab_client.methods.correlations import correlation_of
from modallab_client.results import Correlation
from modallab_client.stored import Identified, id_of


class Correlations(Shelf):
    """Correlations on the service."""

    path = "/v1/correlations"

    def create(
        self,
        modal_model_id: Identified,
        structure_id: Identified,
        *,
        count: int | None = None,
        reduction: str | Mapping[str, Any] | None = None,
        measurement_id: Identified | None = None,
        bands: Sequence[Sequence[float]] | None = None,
        exclude: Sequence[Sequence[float]] = (),
    ) -> Correlation:
        """Return the correlation of measured modes, and measured FRFs, with those of a model.

        Parameters
        ----------
        modal_model_id, structure_id
            The measured modes and the model.
        count
            Elastic modes of the model; left out: as many as were measured.
        reduction
            Of the model's mass to the measured DoFs, for cross- and auto-orthogonality: a kind of
            `lab.catalog.reductions()`, or `{"kind": "serep", "parameters": {"modes": 8}}`.
        measurement_id
            FRFs to be held against the model's: FRAC and FDAC.
        bands, exclude
            Pairs (lower, upper) in Hz of FRFs whose lines alone count, or are left out.
        """
        body = _wire.body(modal_model_id=id_of(modal_model_id), structure_id=id_of(structure_id), count=count)
        body |= _wire.body(reduction=reduction, measurement_id=id_of(measurement_id))
        body |= _wire.body(bands=bands, exclude=exclude or None)
        return self._read(self._transport.request("POST", self.path, json=body))

    def get(self, correlation_id: Identified) -> Correlation:
        """Return a correlation."""
        return self._read(self._transport.request("GET", f"{self.path}/{id_of(correlation_id)}"))

    def _read(self, reply: Any) -> Correlation:
        arrays = None
        if reply.get("responses") is not None:  # an FDAC is too large for JSON
            arrays = self._transport.npz(f"{self.path}/{reply['id']}/arrays")
        return _wire.read(correlation_of, reply, arrays)
