"""Modal models: extracted from a measurement, or brought from elsewhere."""

from collections.abc import Sequence
from pathlib import Path
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from modallab_client import _wire
from modallab_client._sync.jobs import Job
from modallab_client._sync.shelf import Shelf
from modallab_client.methods.extraction import fit_of
from modallab_client.methods.modal_models import modal_model_of
from modallab_client.models import Frf
from modallab_client.options import ExtractionOptions
from modallab_client.results import (
    FitPlotData,
    ModalModel,
    ModalPair,
    ModalReciprocityCheck,
    StabilisationChart,
)
from modallab_client.stored import Identified, id_of


class ModalModels(Shelf):
    """Modal models on the service."""

    path = "/v1/modal-models"

    def start(
        self,
        measurement_id: Identified,
        *,
        method: str | None = None,
        bands: str | Sequence[Sequence[float]] = "auto",
        exclude: Sequence[Sequence[float]] = (),
        n_modes: int | None = None,
        correct_window_damping: bool = False,
        **options: Unpack[ExtractionOptions],
    ) -> Job[ModalModel]:
        """Start the extraction of modes; `result` of the job gives the modal model.

        Parameters
        ----------
        measurement_id
            The measurement.
        method
            One of `lab.catalog.extraction_methods()`; left out: `poly_reference_lscf` with several
            references, `dobson` with one, and `choices["method"]` of the result tells why.
        bands
            `auto`, or one (lower, upper) in Hz for each mode; of a global method each with one or more.
        exclude
            Pairs (lower, upper) in Hz whose lines are left out.
        n_modes
            Modes wanted; left out: as many as show.
        correct_window_damping
            Take what an exponential window added out of the loss factors.
        options
            Options of the method, as `lines` and `damping`; left out: chosen from the data, which `choices`
            of the result tell. Their meaning: `modallab_client.options.ExtractionOptions`.
        """
        body = _wire.body(
            measurement_id=id_of(measurement_id),
            method=method,
            bands=bands,
            exclude=exclude or None,
            n_modes=n_modes,
            options=_wire.body(**options) or None,
            correct_window_damping=correct_window_damping or None,  # left out, it is not done
        )
        job = self._transport.request("POST", "/v1/modal-models", json=body)
        return Job(job["id"], self._transport, self.get)

    def get(self, modal_model_id: Identified, *, details: Sequence[str] = ()) -> ModalModel:
        """Return a modal model with its shapes.

        Parameters
        ----------
        modal_model_id
            The modal model.
        details
            `flags` and `notes` that are listed in full; left out: of many FRFs, and of notes that differ in
            numbers only, the first and how many.
        """
        params = {"details": list(details)} if details else None
        about = self._transport.request("GET", f"/v1/modal-models/{id_of(modal_model_id)}", params=params)
        arrays = self._transport.npz(f"/v1/modal-models/{id_of(modal_model_id)}/arrays")
        return _wire.read(modal_model_of, about, arrays)

    def select(
        self, modal_model_id: Identified, *, drop: Sequence[int] = (), merge: Sequence[Sequence[int]] = ()
    ) -> ModalModel:
        """Return a new modal model without some modes, or with one mode in place of several.

        Nothing is extracted again: frequencies and loss factors of merged modes are averaged by inverse
        variance, their modal constants added. The modes are numbered anew.

        Parameters
        ----------
        modal_model_id
            The modal model, which stays as it is.
        drop
            Numbers of modes, from 1.
        merge
            Groups of numbers; the modes of each become one.
        """
        body = {"drop": list(drop), "merge": [list(group) for group in merge]}
        path = f"{self.path}/{id_of(modal_model_id)}/select"
        reply = self._transport.request("POST", path, json=body)
        return self.get(reply["id"])

    def fit(
        self, modal_model_id: Identified, *, mode: int, response: str, reference: str | None = None
    ) -> FitPlotData:
        """Return one of the fits that a modal model was collated from, to be drawn.

        Parameters
        ----------
        modal_model_id
            A model by a single-mode method.
        mode
            Counted from 1.
        response
            One of the model's `dofs`, in whose FRF.
        reference
            One of the model's `references`, which may be left out where there is but one.
        """
        path = f"{self.path}/{id_of(modal_model_id)}/fits"
        query = _wire.body(mode=mode, response=response, reference=reference)
        reply = self._transport.request("GET", path, params=query)
        return _wire.read(fit_of, reply)

    def chart(self, modal_model_id: Identified, points: int = 800) -> StabilisationChart:
        """Return the stabilisation chart of a model by a global method.

        Parameters
        ----------
        modal_model_id
            The modal model.
        points
            Lines of the mode indicators beside it, about.
        """
        path = f"{self.path}/{id_of(modal_model_id)}/chart"
        reply = self._transport.request("GET", path, params={"points": points})
        return _wire.reply(StabilisationChart, reply)

    def frf(self, modal_model_id: Identified, *, kind: str | None = None) -> Frf:
        """Return the FRFs that modes and residuals make, on the lines of the measurement they were read from.

        Parameters
        ----------
        modal_model_id
            The modal model.
        kind
            `receptance`, `mobility` or `inertance`; left out: as measured.
        """
        path = f"{self.path}/{id_of(modal_model_id)}/frf"
        return _wire.read(_wire.frf, self._transport.npz(path, _wire.body(kind=kind)))

    def reciprocity(self, modal_model_id: Identified, other_id: Identified) -> tuple[ModalPair, ...]:
        """Return the ratios of modal constants to those of a test with exchanged force and response.

        Parameters
        ----------
        modal_model_id, other_id
            Two modal models, each with the other's drive point among its responses.
        """
        path = f"{self.path}/{id_of(modal_model_id)}/reciprocity"
        reply = self._transport.request("GET", path, params={"other": id_of(other_id)})
        return _wire.reply(ModalReciprocityCheck, reply).pairs

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

    def uff(self, modal_model_id: Identified) -> bytes:
        """Return the modes as a universal file (dataset 55)."""
        content: bytes = self._transport.request("GET", f"{self.path}/{id_of(modal_model_id)}/modes.uff")
        return content
