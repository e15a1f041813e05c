"""Studies: how surely an updating method finds known errors from noisy modes."""

from collections.abc import Mapping, Sequence
from typing import Any

from modallab_client import _wire
from modallab_client._async.jobs import AsyncJob
from modallab_client._async.shelf import AsyncShelf
from modallab_client._read import read_as
from modallab_client.methods.studies import StudyCoefficients, study_coefficients
from modallab_client.results import Study
from modallab_client.stored import Identified, id_of


class AsyncStudies(AsyncShelf):
    """Studies on the service."""

    path = "/v1/studies"

    async def start(
        self,
        structure_id: Identified,
        truth_id: Identified,
        *,
        dofs: Sequence[str],
        method: str | None = None,
        levels: Sequence[str | Mapping[str, Any]] | None = None,
        divisions: Mapping[str, str | Sequence[Any]] | None = None,
        seeds: Sequence[int] | None = None,
        count: int | None = None,
        parts: Sequence[str] | None = None,
        lower: float | None = None,
        upper: float | None = None,
        options: Mapping[str, Any] | None = None,
    ) -> AsyncJob[Study]:
        """Start updates of the structure to noisy modes of the truth; `result` of the job gives the study.

        Parameters
        ----------
        structure_id, truth_id
            The model, and a changed copy of it whose modes are drawn.
        dofs
            DoFs of the shapes.
        method
            One that takes modes and corrects coefficients, or locates by one step, as `zhang_subspace`; left
            out: `one_shot`.
        levels
            Of `NL1` to `NL4`, or `{"name": "mine", "eigenvalue": 0.005, "eigenvector": 0.05}`; left out: the
            four.
        divisions
            Macro elements by a name of your own: `auto`, `each` member by itself, or lists of members.
        seeds
            Of the noise, a run each; left out: 0 to 9.
        count
            Modes that are measured; left out: 10.
        parts, lower, upper, options
            As of an update.
        """
        body = _wire.body(method=method, levels=levels, divisions=divisions, count=count, options=options)
        body |= _wire.body(parts=parts, lower=lower, upper=upper)
        if seeds is not None:
            body["seeds"] = list(seeds)
        body |= {"structure_id": id_of(structure_id), "truth_id": id_of(truth_id), "dofs": list(dofs)}
        job = await self._transport.request("POST", self.path, json=body)
        return AsyncJob(job["id"], self._transport, self.get)

    async def get(self, study_id: Identified) -> Study:
        """Return a finished study."""
        reply = await self._transport.request("GET", f"{self.path}/{id_of(study_id)}")
        study: Study = _wire.read(read_as, Study, reply)
        return study

    async def coefficients(self, study_id: Identified) -> StudyCoefficients:
        """Return the coefficients that all runs of a study found."""
        arrays = await self._transport.npz(f"{self.path}/{id_of(study_id)}/arrays")
        return _wire.read(study_coefficients, arrays)
