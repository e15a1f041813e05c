"""Updates: a model brought closer to a test."""

from collections.abc import Mapping, Sequence
from typing import Any, Unpack

from modallab_client import _wire
from modallab_client._async.jobs import AsyncJob
from modallab_client._async.shelf import AsyncShelf
from modallab_client.methods.update_arrays import (
    Covariance,
    PosteriorDraws,
    UpdatedMatrices,
    covariance_of,
    draws_of,
    matrices_of,
)
from modallab_client.methods.updates import Update, update_of
from modallab_client.options import UpdateOptions
from modallab_client.stored import Identified, id_of


class AsyncUpdates(AsyncShelf):
    """Updates on the service."""

    path = "/v1/updates"

    async def start(
        self,
        structure_id: Identified,
        modal_model_id: Identified | None = None,
        *,
        measurement_id: Identified | None = None,
        noise_floor: float | None = None,
        bands: Sequence[Sequence[float]] | None = None,
        exclude: Sequence[Sequence[float]] = (),
        method: str = "inverse_eigensensitivity",
        macros: str | Mapping[str, Any] | Sequence[str | Sequence[int]] | None = None,
        parts: Sequence[str] | None = None,
        lower: float | None = None,
        upper: float | None = None,
        parameterisation: Mapping[str, Any] | None = None,
        options: Mapping[str, Any] | None = None,
        **keywords: Unpack[UpdateOptions],
    ) -> AsyncJob[Update]:
        """Start an update of the structure to modes or FRFs; `result` of the job gives it.

        Parameters
        ----------
        structure_id, modal_model_id
            The model, and the modes it shall have.
        measurement_id, noise_floor
            In place of modes, for a method that takes FRFs, as `frf_residual`: the measurement, and the
            relative random error of every FRF beside what its coherence tells.
        bands, exclude
            Pairs (lower, upper) in Hz of FRFs whose lines alone count, or are left out.
        method
            One of `lab.catalog.updating_methods()`.
        macros
            `auto`, `each` member by itself, the macro elements as lists of members or names of groups, or a
            rule: `{"by": "groups"}`, or `{"by": "partition", "count": 12}` for connected parts of like size.
        parts
            Of mass, stiffness, axial, bending, damping, or properties: density, modulus, area and
            second_moment of bars, thickness of plates; left out: mass and stiffness, of a method of complex
            modes and of FRFs damping too.
        lower, upper
            Bounds of every coefficient, 1 = no change.
        parameterisation, options
            The same and more as the JSON has it, as `{"attached": {"point_mass": "each"}}` of masses,
            springs and joints at nodes; the keywords above go into them.
        keywords
            Options of the method, as `max_iterations` and `prior`. Their meaning:
            `modallab_client.options.UpdateOptions`.
        """
        chosen = dict(parameterisation or {}) | _wire.body(
            macros=macros, parts=parts, lower=lower, upper=upper
        )
        tuned = dict(options or {}) | _wire.body(**keywords)
        body = _wire.body(parameterisation=chosen or None, options=tuned or None, method=method)
        body |= _wire.body(
            modal_model_id=id_of(modal_model_id),
            measurement_id=id_of(measurement_id),
            noise_floor=noise_floor,
        )
        body |= _wire.body(bands=bands, exclude=exclude or None)
        body["structure_id"] = id_of(structure_id)
        job = await self._transport.request("POST", self.path, json=body)
        return AsyncJob(job["id"], self._transport, self.get)

    async def get(self, update_id: Identified) -> Update:
        """Return a finished update, of the type of its kind."""
        reply = await self._transport.request("GET", f"/v1/updates/{id_of(update_id)}")
        return _wire.read(update_of, reply)

    async def covariance(self, update_id: Identified) -> Covariance:
        """Return the covariance of an update's coefficients, by the errors of the data alone."""
        arrays = await self._transport.npz(f"/v1/updates/{id_of(update_id)}/covariance")
        return _wire.read(covariance_of, arrays)

    async def sample(self, update_id: Identified) -> PosteriorDraws:
        """Return the draws from the posterior of an update that was asked for `samples`."""
        arrays = await self._transport.npz(f"/v1/updates/{id_of(update_id)}/sample")
        return _wire.read(draws_of, arrays)

    async def matrices(self, update_id: Identified) -> UpdatedMatrices:
        """Return the matrices of a direct method."""
        arrays = await self._transport.npz(f"/v1/updates/{id_of(update_id)}/arrays")
        return _wire.read(matrices_of, arrays)
