"""Structures: described by numbers, or brought as files and matrices."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from modallab_client import _matrices, _wire
from modallab_client._async.shelf import AsyncShelf
from modallab_client._plausibility import warned
from modallab_client.results import Structure

JsonObject = Mapping[str, Any]


class AsyncDescribed(AsyncShelf):
    """Ways to a new structure."""

    path = "/v1/structures"

    async def create(self, **body: Any) -> Structure:
        """Return a new structure; the keywords are the JSON's names, `kind` among them."""
        return warned(_wire.reply(Structure, await self._transport.request("POST", self.path, json=body)))

    async def beam(
        self,
        *,
        length: float,
        n_elements: int,
        section: JsonObject,
        material: JsonObject,
        damping: JsonObject | None = None,
        theory: str | None = None,
        supports: Sequence[JsonObject] | None = None,
        effects: Sequence[JsonObject] | None = None,
    ) -> Structure:
        """Return a new straight beam along X, its nodes 1 to n + 1 with DoFs Y and RZ.

        Parameters
        ----------
        length
            m.
        n_elements
            Elements of equal length.
        section
            `area` in m^2 and `second_moment` in m^4.
        material
            `modulus` in N/m^2 and `density` in kg/m^3.
        damping
            `law` and its coefficients; left out: none.
        theory
            `bernoulli_euler` (the default) or `timoshenko`.
        supports
            `[{"node": 1, "directions": ["Y", "RZ"]}]`; left out: free.
        effects
            What has no field here: `[{"kind", "at", "parameters"}]`.
        """
        shape = _wire.body(length=length, n_elements=n_elements, section=section, material=material)
        optional = _wire.body(damping=damping, theory=theory, supports=supports, effects=effects)
        return await self.create(kind="beam", **shape, **optional)

    async def frame(
        self,
        *,
        nodes: Mapping[str, Sequence[float]],
        sections: Mapping[str, JsonObject],
        materials: Mapping[str, JsonObject],
        members: Sequence[JsonObject],
        damping: JsonObject | None = None,
        theory: str | None = None,
        supports: Sequence[JsonObject] | None = None,
        effects: Sequence[JsonObject] | None = None,
    ) -> Structure:
        """Return a new frame of members between nodes; a plane frame lies in X, Y.

        Parameters
        ----------
        nodes
            Coordinates in m by node number, `{"1": [0.0, 0.0]}`.
        sections, materials
            By name; fields as of a beam.
        members
            `[{"number": 1, "nodes": [1, 2], "section": "bar", "material": "alloy"}]`.
        damping, theory, supports, effects
            As of a beam.
        """
        shape = _wire.body(nodes=nodes, sections=sections, materials=materials, members=members)
        optional = _wire.body(damping=damping, theory=theory, supports=supports, effects=effects)
        return await self.create(kind="frame", **shape, **optional)

    async def plate(
        self,
        *,
        length: float,
        width: float,
        thickness: float,
        n_elements: Sequence[int],
        material: JsonObject,
        edges: Mapping[str, str] | None = None,
        damping: JsonObject | None = None,
        supports: Sequence[JsonObject] | None = None,
        effects: Sequence[JsonObject] | None = None,
    ) -> Structure:
        """Return a new flat rectangular plate in X, Y with DoFs Z, RX and RY, nodes row by row.

        Parameters
        ----------
        length, width, thickness
            m, along X, Y and Z.
        n_elements
            Along X and along Y.
        material
            `modulus` in N/m^2, `density` in kg/m^3 and, left out 0.3, `poisson_ratio`.
        edges
            How `left`, `right`, `bottom` and `top` are held: `simply_supported` or `clamped`; left out: free.
        damping, supports, effects
            As of a beam.
        """
        shape = _wire.body(length=length, width=width, thickness=thickness, material=material, edges=edges)
        optional = _wire.body(damping=damping, supports=supports, effects=effects)
        return await self.create(kind="plate", n_elements=list(n_elements), **shape, **optional)

    async def upload(
        self,
        file: str | Path | bytes,
        *,
        dofs: Sequence[str] | None = None,
        name: str | None = None,
        damping: JsonObject | None = None,
    ) -> Structure:
        """Return a structure from Nastran bulk data or a file of matrices, by path or as bytes.

        Parameters
        ----------
        file
            Bulk data, npz, zip of Matrix Market or OUTPUT4 files; its content says which, not its name. Or an
            OUTPUT4 file of two matrices, whose names begin with M and K, with their `dofs`.
        dofs
            Of an OUTPUT4 file: (n,) `"5:+Z"`, in the order of the rows.
        name
            Of the structure.
        damping
            `law` and its coefficients; left out: what the file's elements have.
        """
        if dofs is not None:
            file = _matrices.with_table(file if isinstance(file, bytes) else Path(file).read_bytes(), dofs)
        return await self._import(file, name=name, damping=damping)

    async def _import(
        self,
        file: str | Path | bytes,
        *,
        name: str | None,
        damping: JsonObject | None,
        mesh: str | None = None,
    ) -> Structure:
        content = file if isinstance(file, bytes) else Path(file).read_bytes()
        file_name = "model" if isinstance(file, bytes) else Path(file).name
        law = None if damping is None else json.dumps(damping)
        data = _wire.body(name=name, damping=law, mesh=mesh)
        reply = await self._transport.request(
            "POST", f"{self.path}/import", files={"file": (file_name, content)}, data=data
        )
        return warned(_wire.reply(Structure, reply))

    async def import_mesh(
        self,
        file: str | Path | bytes,
        *,
        groups: Mapping[str, JsonObject],
        supports: Sequence[JsonObject] = (),
        left_out: Sequence[str] = (),
        length_unit: float = 1.0,
        name: str | None = None,
        damping: JsonObject | None = None,
    ) -> Structure:
        """Return a structure from a mesh of gmsh, Abaqus, VTK or Medit, by path or as bytes.

        Parameters
        ----------
        file
            The mesh; its content says of which program.
        groups
            By name `{"material": {...}, "thickness": m}` of triangles and quadrilaterals, or
            `{"material": {...}, "section": {...}}` of lines.
        supports
            `[{"group": "left", "directions": ["Z", "RX", "RY"]}]`: points that are held.
        left_out
            Groups, or types of cells as `line`, that become no members.
        length_unit
            Of the mesh, m.
        name, damping
            As of `upload`.
        """
        mesh = {"groups": groups, "supports": list(supports), "left_out": list(left_out)}
        description = json.dumps(mesh | {"length_unit": length_unit})
        return await self._import(file, name=name, damping=damping, mesh=description)

    async def import_matrices(
        self,
        *,
        dofs: Sequence[str],
        mass: Any = None,
        stiffness: Any = None,
        groups: Mapping[str, tuple[Any, Any]] | None = None,
        coordinates: Mapping[int, Sequence[float]] | None = None,
        name: str | None = None,
        damping: JsonObject | None = None,
    ) -> Structure:
        """Return a structure from its mass and stiffness matrices, (n, n), whole or in named groups.

        Parameters
        ----------
        dofs
            (n,) `"5:+Z"`, in the order of the rows.
        mass, stiffness
            Arrays or scipy's sparse ones.
        groups
            In place of these two what each part of the model adds to them, by its name.
        coordinates
            Of the nodes, m; left out: not known.
        name, damping
            As of `upload`.
        """
        arrays = _matrices.npz(dofs, mass, stiffness, groups, coordinates)
        return await self.upload(arrays, name=name, damping=damping)

    async def catalogue(self, name: str) -> Structure:
        """Return a new structure from the catalogue; `lab.catalog.structures()` lists the names."""
        return await self.create(kind="catalogue", name=name)
