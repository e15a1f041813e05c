"""Modal models: extracted from a measurement, or brought from elsewhere."""

from collections.abc import Sequence

from numpy.typing import ArrayLike

from modallab_client import _wire
from modallab_client._sync.jobs import Job
from modallab_client._sync.transport import Transport
from modallab_client.models import ModalModel


class ModalModels:
    """Modal models on the service."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport

    def start(
        self,
        measurement_id: str,
        *,
        method: str = "dobson",
        bands: str | Sequence[Sequence[float]] = "auto",
        n_modes: int | None = None,
    ) -> Job[ModalModel]:
        """Start the extraction of modes; `result` of the job gives the modal model.

        Parameters
        ----------
        measurement_id
            The measurement.
        method
            One of `lab.catalog.extraction_methods()`.
        bands
            `auto`, or one (lower, upper) in Hz for each mode.
        n_modes
            Modes wanted; left out: as many as show.
        """
        body = _wire.body(measurement_id=measurement_id, method=method, bands=bands, n_modes=n_modes)
        job = self._transport.request("POST", "/v1/modal-models", json=body)
        return Job(job["id"], self._transport, self.get)

    def get(self, modal_model_id: str) -> ModalModel:
        """Return a modal model with its shapes."""
        about = self._transport.request("GET", f"/v1/modal-models/{modal_model_id}")
        arrays = self._transport.npz(f"/v1/modal-models/{modal_model_id}/arrays")
        return _wire.read(_wire.modal_model, about, arrays)

    def import_(
        self,
        *,
        frequencies: Sequence[float],
        loss_factors: Sequence[float],
        shapes: ArrayLike,
        dofs: Sequence[str],
    ) -> ModalModel:
        """Return a modal model from known modes.

        Parameters
        ----------
        frequencies, loss_factors
            (n_modes,), Hz and -.
        shapes
            (n_dof, n_modes), complex or real, 1/sqrt(kg).
        dofs
            (n_dof,), the DoFs of the shapes.
        """
        body = {
            "frequencies": [float(f) for f in frequencies],
            "loss_factors": [float(eta) for eta in loss_factors],
            "shapes": _wire.pairs(shapes),
            "dofs": list(dofs),
        }
        reply = self._transport.request("POST", "/v1/modal-models/import", json=body)
        return self.get(reply["id"])

    def delete(self, modal_model_id: str) -> None:
        """Remove a modal model."""
        self._transport.request("DELETE", f"/v1/modal-models/{modal_model_id}")
