"""Modal models: extracted from a measurement, or brought from elsewhere."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from modallab_client import _wire
from modallab_client._sync.jobs import Job
from modallab_client._sync.shelf import Shelf
from modallab_client.models import ModalModel


class ModalModels(Shelf):
    """Modal models on the service."""

    path = "/v1/modal-models"

    def start(
        self,
        measurement_id: str,
        *,
        method: str = "dobson",
        bands: str | Sequence[Sequence[float]] = "auto",
        n_modes: int | None = None,
        correct_window_damping: bool = False,
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
        correct_window_damping
            Take what an exponential window added out of the loss factors.
        """
        body = _wire.body(
            measurement_id=measurement_id,
            method=method,
            bands=bands,
            n_modes=n_modes,
            correct_window_damping=correct_window_damping or None,  # left out, it is not done
        )
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
        frequencies: ArrayLike,
        loss_factors: ArrayLike,
        shapes: ArrayLike,
        dofs: Sequence[str],
        normalisation: str = "mass",
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
        normalisation
            `mass`, or `none` for shapes of any length.
        """
        columns = _wire.pairs(np.transpose(shapes))
        lines = zip(_wire.numbers(frequencies), _wire.numbers(loss_factors), columns, strict=True)
        modes = [{"frequency": f, "loss_factor": eta, "shape": shape} for f, eta, shape in lines]
        body = {"modes": modes, "dofs": list(dofs), "normalisation": normalisation}
        reply = self._transport.request("POST", "/v1/modal-models/import", json=body)
        return self.get(reply["id"])

    def upload(self, file: str | Path | bytes) -> ModalModel:
        """Return a modal model from a universal file (dataset 55), by path or as bytes."""
        content = file if isinstance(file, bytes) else Path(file).read_bytes()
        name = "modes" if isinstance(file, bytes) else Path(file).name
        files = {"file": (name, content)}
        reply = self._transport.request("POST", "/v1/modal-models/import", files=files)
        return self.get(reply["id"])

    def uff(self, modal_model_id: str) -> bytes:
        """Return the modes as a universal file (dataset 55)."""
        content: bytes = self._transport.request("GET", f"{self.path}/{modal_model_id}/modes.uff")
        return content
