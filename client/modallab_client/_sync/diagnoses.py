"""Diagnoses: what a model lacks to explain a measurement."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from modallab_client import _wire
from modallab_client._read import read_as
from modallab_client._sync.jobs import Job
from modallab_client._sync.shelf import Shelf
from modallab_client.methods.diagnoses import DiagnosisCurves, diagnosis_curves
from modallab_client.results import Diagnosis


class Diagnoses(Shelf):
    """Diagnoses on the service."""

    path = "/v1/diagnoses"

    def start(
        self,
        structure_id: str,
        measurement_id: str,
        *,
        suspects: str | Sequence[str] = "all",
        hold_out: Mapping[str, Any] | None = None,
        tolerances: Mapping[str, float] | None = None,
        follow_ups: Sequence[Mapping[str, Any]] | None = None,
        act: bool | None = None,
        noise_floor: float | None = None,
        max_effects: int | None = None,
        seed: int = 0,
    ) -> Job[Diagnosis]:
        """Start the search for what the model lacks; `result` of the job gives the diagnosis.

        Parameters
        ----------
        structure_id, measurement_id
            The model, and the measurement it shall explain.
        suspects
            `all`, or kinds of `lab.catalog.effects()`.
        hold_out
            FRFs kept out of every fit: `fraction`, and `dofs`, which need not have been measured.
        tolerances
            What may differ a little and is no missing effect, one standard deviation by name.
        follow_ups
            Further tests: `[{"measurement_id", "changed": {"level_factor": 3.0}}]`.
        act
            Run the proposed next test where the rig is ours.
        noise_floor
            Relative random error of every FRF, of its median where it is below that: beside what coherence
            tells, and alone where there is none.
        max_effects
            Effects added at most.
        seed
            The same seed gives the same diagnosis.
        """
        body = {"structure_id": structure_id, "measurement_id": measurement_id, "suspects": suspects}
        more = _wire.body(hold_out=hold_out, tolerances=tolerances, follow_ups=follow_ups)
        how = _wire.body(act=act, noise_floor=noise_floor, max_effects=max_effects, seed=seed)
        job = self._transport.request("POST", "/v1/diagnoses", json={**body, **more, **how})
        return Job(job["id"], self._transport, self.get)

    def get(self, diagnosis_id: str) -> Diagnosis:
        """Return a finished diagnosis with its curves."""
        reply = self._transport.request("GET", f"/v1/diagnoses/{diagnosis_id}")
        diagnosis: Diagnosis = _wire.read(read_as, Diagnosis, reply)
        return replace(diagnosis, curves=self.curves(diagnosis_id))

    def curves(self, diagnosis_id: str) -> DiagnosisCurves:
        """Return the FRFs measured, and predicted before and after what was added."""
        arrays = self._transport.npz(f"/v1/diagnoses/{diagnosis_id}/arrays")
        return _wire.read(diagnosis_curves, arrays)

    def report(self, diagnosis_id: str) -> str:
        """Return the report, one self-contained HTML page."""
        content: bytes = self._transport.request("GET", f"/v1/diagnoses/{diagnosis_id}/report")
        return content.decode()
