"""Diagnoses: what a model lacks to explain a measurement."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Unpack

from modallab_client import _wire
from modallab_client._read import read_as
from modallab_client._sync.jobs import Job
from modallab_client._sync.shelf import Shelf
from modallab_client.methods.diagnoses import DiagnosisCurves, diagnosis_curves
from modallab_client.options import DiagnosisOptions
from modallab_client.results import Adoption, Diagnosis
from modallab_client.stored import Identified, id_of


class Diagnoses(Shelf):
    """Diagnoses on the service."""

    path = "/v1/diagnoses"

    def start(
        self,
        structure_id: Identified,
        measurement_id: Identified,
        *,
        follow_ups: Sequence[Mapping[str, Any]] | None = None,
        **options: Unpack[DiagnosisOptions],
    ) -> Job[Diagnosis]:
        """Start the search for what the model lacks; `result` of the job gives the diagnosis.

        Parameters
        ----------
        structure_id, measurement_id
            The model, and the measurement it shall explain.
        follow_ups
            Further tests: `[{"measurement_id", "changed": {"level_factor": 3.0}}]`.
        options
            Options of the diagnosis, as `suspects`, `hold_out` and `tolerances`. Their meaning:
            `modallab_client.options.DiagnosisOptions`.
        """
        body = {
            "structure_id": id_of(structure_id),
            "measurement_id": id_of(measurement_id),
            "suspects": "all",
            "seed": 0,
        }
        body |= _wire.body(follow_ups=follow_ups, **options)
        job = self._transport.request("POST", "/v1/diagnoses", json=body)
        return Job(job["id"], self._transport, self.get)

    def get(self, diagnosis_id: Identified) -> Diagnosis:
        """Return a finished diagnosis with its curves."""
        reply = self._transport.request("GET", f"/v1/diagnoses/{id_of(diagnosis_id)}")
        diagnosis: Diagnosis = _wire.read(read_as, Diagnosis, reply)
        return replace(diagnosis, curves=self.curves(diagnosis_id))

    def adopt(self, diagnosis_id: Identified) -> Adoption:
        """Return the ids of a model and a log book that hold the unknown effect as a tabulated one."""
        reply = self._transport.request("POST", f"/v1/diagnoses/{id_of(diagnosis_id)}/adopt")
        adoption: Adoption = _wire.read(read_as, Adoption, reply)
        return adoption

    def curves(self, diagnosis_id: Identified) -> DiagnosisCurves:
        """Return the FRFs measured, and predicted before and after what was added."""
        arrays = self._transport.npz(f"/v1/diagnoses/{id_of(diagnosis_id)}/arrays")
        return _wire.read(diagnosis_curves, arrays)

    def report(
        self,
        diagnosis_id: Identified,
        *,
        title: str | None = None,
        object: str | None = None,
        author: str | None = None,
        date: str | None = None,
    ) -> str:
        """Return the report, one self-contained HTML page.

        Parameters
        ----------
        diagnosis_id
            The diagnosis.
        title, object, author, date
            What the report says of itself at its top; left out: nothing.
        """
        heading = _wire.body(title=title, object=object, author=author, date=date)
        path = f"/v1/diagnoses/{id_of(diagnosis_id)}/report"
        content: bytes = self._transport.request("GET", path, params=heading)
        return content.decode()
