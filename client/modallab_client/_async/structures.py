"""Structures: made, changed, and their modes."""

from collections.abc import Mapping, Sequence
from typing import Any

from modallab_client import _wire, _wire_correlation
from modallab_client._async.described import AsyncDescribed
from modallab_client._async.modal_models import AsyncModalModels
from modallab_client._plausibility import warned
from modallab_client.correlation import Expansion, ReducedModel
from modallab_client.models import Frf, ModeShapes
from modallab_client.results import ModalModel, Structure, StructureGeometry, StructureModes
from modallab_client.stored import Identified, id_of

JsonObject = Mapping[str, Any]


class AsyncStructures(AsyncDescribed):
    """Structures on the service; none is ever changed in place."""

    async def change(
        self,
        structure_id: Identified,
        changes: Sequence[JsonObject] = (),
        *,
        members: Sequence[int] | None = None,
        node: int | None = None,
        dof: str | None = None,
        property: str | None = None,
        factor: float | None = None,
        value: float | None = None,
    ) -> Structure:
        """Return a new structure with something changed; several changes as a list, one by keywords.

        Parameters
        ----------
        structure_id
            The structure to start from; it stays as it is.
        changes
            `[{"members": [1, 2], "property": "density", "factor": 2.0}]`.
        members, node, dof
            Where the one change by keywords is made.
        property
            Of members: density, modulus, axial_stiffness, bending_stiffness, loss_factor, area,
            second_moment, thickness; of a node: mass, joint_stiffness; of a DoF: ground_stiffness.
        factor, value
            `factor` multiplies, `value` sets.
        """
        location = _wire.body(members=members, node=node, dof=dof)
        change = location | _wire.body(property=property, factor=factor, value=value)
        body = {"changes": [*changes, change] if change else list(changes)}
        path = f"/v1/structures/{id_of(structure_id)}/changes"
        return warned(_wire.reply(Structure, await self._transport.request("POST", path, json=body)))

    async def get(self, structure_id: Identified) -> Structure:
        """Return a structure."""
        path = f"/v1/structures/{id_of(structure_id)}"
        return _wire.reply(Structure, await self._transport.request("GET", path))

    async def body(self, structure_id: Identified) -> dict[str, Any]:
        """Return the body of the request that described a structure; `create(**body)` makes the same one.

        Of a changed structure it is `{"changes": [...]}`, for `change` of the structure that it was made
        from.

        Raises
        ------
        NotFoundError
            If no request described it: it was computed, or read from a file.
        ForbiddenError
            If it is only shared with one.
        """
        path = f"/v1/structures/{id_of(structure_id)}/body"
        return _wire.read(dict, await self._transport.request("GET", path))

    async def modes(self, structure_id: Identified, count: int = 10) -> StructureModes:
        """Return frequencies and loss factors of the first elastic modes."""
        path = f"/v1/structures/{id_of(structure_id)}/modes"
        reply = await self._transport.request("GET", path, params={"count": count})
        return _wire.reply(StructureModes, reply)

    async def mode_shapes(self, structure_id: Identified, count: int = 10) -> ModeShapes:
        """Return the first elastic modes with their shapes."""
        path = f"/v1/structures/{id_of(structure_id)}/modes/arrays"
        return _wire.read(_wire.mode_shapes, await self._transport.npz(path, {"count": count}))

    async def frf(
        self,
        structure_id: Identified,
        *,
        drive: str,
        responses: Sequence[str],
        kind: str | None = None,
        frequency_max: float | None = None,
        n_lines: int | None = None,
    ) -> Frf:
        """Return the exact FRFs of the structure, without a rig.

        Parameters
        ----------
        structure_id
            The structure.
        drive, responses
            DoFs: `"1:+Y"`, `["1:+Y", "5:+Y"]`.
        kind
            `inertance` (the default), `mobility` or `receptance`; these two start above 0 Hz.
        frequency_max
            Hz; left out: 800.
        n_lines
            0 Hz counted; left out: 401.
        """
        query = _wire.body(drive=drive, responses=list(responses), kind=kind)
        lines = _wire.body(frequency_max=frequency_max, n_lines=n_lines)
        path = f"{self.path}/{id_of(structure_id)}/frf"
        return _wire.read(_wire.frf, await self._transport.npz(path, query | lines))

    async def synthetic_modes(
        self,
        structure_id: Identified,
        *,
        dofs: Sequence[str],
        count: int = 10,
        noise: JsonObject | None = None,
        seed: int | None = None,
    ) -> ModalModel:
        """Return the structure's modes as a modal model, as if they had been measured.

        Parameters
        ----------
        structure_id
            The structure.
        dofs
            DoFs of the shapes.
        count
            Elastic modes wanted.
        noise
            `{"eigenvalue": 0.005, "eigenvector": 0.05, "distribution": "uniform"}`, relative.
        seed
            Of the noise; the same seed gives the same numbers.
        """
        body = _wire.body(count=count, dofs=dofs, noise=noise, seed=seed)
        path = f"/v1/structures/{id_of(structure_id)}/synthetic-modes"
        reply = await self._transport.request("POST", path, json=body)
        return await AsyncModalModels(self._transport).get(reply["id"])

    async def expanded_modes(
        self, structure_id: Identified, modal_model_id: Identified, *, reduction: str | JsonObject = "serep"
    ) -> Expansion:
        """Return measured modes at all DoFs of a structure, as a modal model of their own.

        Parameters
        ----------
        structure_id, modal_model_id
            The model, and the modes as measured.
        reduction
            How all DoFs follow the measured ones: a kind of `lab.catalog.reductions()`, or
            `{"kind": "dynamic", "parameters": {"frequency": 60.0}}`.
        """
        body = {"modal_model_id": id_of(modal_model_id), "reduction": reduction}
        path = f"{self.path}/{id_of(structure_id)}/expanded-modes"
        reply = await self._transport.request("POST", path, json=body)
        model = await AsyncModalModels(self._transport).get(reply["id"])
        return _wire.read(_wire_correlation.expansion, reply, model)

    async def reduced(
        self, structure_id: Identified, masters: Sequence[str], *, kind: str = "guyan", **parameters: float
    ) -> ReducedModel:
        """Return the structure at some of its DoFs.

        Parameters
        ----------
        structure_id
            The structure.
        masters
            DoFs that are kept.
        kind
            One of `lab.catalog.reductions()`.
        **parameters
            Its numbers: `frequency` in Hz of `dynamic`, `iterations` of `irs`, `modes` of `serep`.
        """
        query = {"masters": list(masters), "kind": kind, **parameters}
        arrays = await self._transport.npz(f"{self.path}/{id_of(structure_id)}/reduced", query)
        return _wire.read(_wire_correlation.reduced, arrays)

    async def layout(self, structure_id: Identified) -> StructureGeometry:
        """Return nodes, members and free degrees of freedom."""
        path = f"{self.path}/{id_of(structure_id)}/geometry"
        return _wire.reply(StructureGeometry, await self._transport.request("GET", path))

    async def geometry(self, structure_id: Identified) -> bytes:
        """Return nodes and members as a universal file (datasets 15 and 82)."""
        content: bytes = await self._transport.request(
            "GET", f"{self.path}/{id_of(structure_id)}/geometry.uff"
        )
        return content
