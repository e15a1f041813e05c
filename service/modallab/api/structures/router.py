"""Structures: described, changed, solved."""

from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, File, Form, Query, UploadFile, status
from starlette.responses import Response

from modallab.api import array_tables
from modallab.api.arrays import ArraysFormatDep
from modallab.api.deps import IdPath, OwnerDep, SettingsDep, StoreDep
from modallab.api.examples import example, examples
from modallab.api.files import UFF, origin, uff_reply
from modallab.api.media import CsvWanted, csv_or, csv_replies
from modallab.api.modal_models.replies import ExpandedReply, ModalModelReply, modal_model_reply
from modallab.api.modal_models.schemas import SyntheticIn
from modallab.api.offloading.route import OffloadedRoute
from modallab.api.reductions import ReducedQuery, check_size, reduction_in
from modallab.api.shelves import add_routes
from modallab.api.structures.changes import ChangesIn
from modallab.api.structures.damping import damping_of
from modallab.api.structures.expansions import ExpansionIn
from modallab.api.structures.frf import FrfQuery
from modallab.api.structures.mesh import mesh_of
from modallab.api.structures.replies import (
    GeometryReply,
    ModesReply,
    StructureReply,
    geometry_reply,
    modes_reply,
    structure_reply,
)
from modallab.api.structures.schemas import StructureIn
from modallab.api.wire import Text, Wire
from modallab.core.errors import NotFoundError
from modallab.fe.changes import change
from modallab.fe.expansion import expand
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import lowest_modes, synthetic_modes
from modallab.interchange import uff_geometry
from modallab.jobs.model_files import ModelRequest, read_model_confined
from modallab.rig.exact import as_modelled
from modallab.store.base import Store

router = APIRouter(prefix="/structures", tags=["structures"], route_class=OffloadedRoute)
Count = Annotated[int, Query(ge=1, le=100, description="how many elastic modes at most")]

_MODE_COLUMNS = ("mode", "frequency", "loss_factor")
_SECTION = {"area": 5e-4, "second_moment": 4.1667e-9}
_STEEL = {"modulus": 2.09e11, "density": 7800.0}
_BEAM = {"kind": "beam", "length": 1.5, "n_elements": 20, "section": _SECTION, "material": _STEEL}
_FRAME = {
    "kind": "frame",
    "nodes": {"1": [0.0, 0.0], "2": [1.0, 0.0], "3": [1.0, 1.0]},
    "sections": {"bar": _SECTION},
    "materials": {"steel": _STEEL},
    "members": [
        {"number": 1, "nodes": [1, 2], "section": "bar", "material": "steel"},
        {"number": 2, "nodes": [2, 3], "section": "bar", "material": "steel"},
    ],
    "supports": [{"node": 1, "directions": ["X", "Y", "RZ"]}],
}
_PLATE = {
    "kind": "plate",
    "length": 0.6,
    "width": 0.4,
    "thickness": 0.004,
    "n_elements": [12, 8],
    "material": _STEEL,
    "edges": {"left": "clamped"},
}
_MODEL = (
    "Nastran bulk data, a mesh of gmsh, Abaqus, VTK or Medit, npz of matrices, "
    "or zip of Matrix Market or OUTPUT4 files with dofs.txt"
)
_MESH = "of a mesh, as JSON: sections, thicknesses and materials by group, supports, what is left out"
_LAW = "a damping law as JSON; by default what the file's elements have"
_DAMPED = _BEAM | {"damping": {"law": "structural", "stiffness_coefficient": 0.005, "mass_coefficient": 0.0}}
_BODY = examples(
    catalogue={"kind": "catalogue", "name": "chapter-5-beam"}, beam=_DAMPED, frame=_FRAME, plate=_PLATE
)
_CHANGES = {"changes": [{"members": [7], "property": "modulus", "factor": 1.3}]}
_SYNTHETIC = {"count": 8, "dofs": ["1:+Y", "11:+Y", "21:+Y"], "noise": {"eigenvalue": 0.005}, "seed": 3}
_EXPANSION = {"modal_model_id": "77ab10", "reduction": "serep"}


def _stored(
    store: Store, structure: Structure, owner: str, request: Wire | None = None, **inputs: str
) -> Any:
    """Return the reply of a structure after storing it, with the body of the request that described it."""
    body = None if request is None else request.model_dump(mode="json", exclude_unset=True)
    stored = store.structures.add(structure, owner=owner, inputs=inputs, request=body)
    return structure_reply(structure, store.structures.entry(stored))


@router.post(
    "", status_code=status.HTTP_201_CREATED, response_model=StructureReply, summary="Create a structure"
)
def create_structure(body: Annotated[StructureIn, _BODY], store: StoreDep, owner: OwnerDep) -> Any:
    """Return a structure from its description: a beam, a frame, a plate, or one of the catalogue by name."""
    return _stored(store, body.to_domain(), owner, body)


@router.post(
    "/import",
    status_code=status.HTTP_201_CREATED,
    response_model=StructureReply,
    summary="Import a structure",
)
def import_structure(
    file: Annotated[UploadFile, File(description=_MODEL)],
    store: StoreDep,
    settings: SettingsDep,
    owner: OwnerDep,
    name: Annotated[Text, Form(description="name of the structure")] = "",
    damping: Annotated[str | None, Form(description=_LAW, max_length=20_000)] = None,
    mesh: Annotated[str | None, Form(description=_MESH, max_length=1_000_000)] = None,
) -> Any:
    """Return a structure read from a file: Nastran bulk data, a mesh, or matrices."""
    law = None if damping is None else damping_of(damping)
    described = None if mesh is None else mesh_of(mesh)
    limit = settings.upload_limit
    read = read_model_confined(file.file, ModelRequest(law, name, described), largest=limit)
    return _stored(store, read, owner)


@router.get("/{id}", response_model=StructureReply, summary="Get a structure")
def get_structure(id: IdPath, store: StoreDep) -> Any:
    """Return the size of a stored structure and its groups of members."""
    return structure_reply(store.structures.get(id), store.structures.entry(id))


@router.get("/{id}/body", summary="Get the body that described a structure")
def get_structure_body(id: IdPath, store: StoreDep) -> dict[str, Any]:
    """Return the body of the request that described a structure: sent again, it makes the same one.

    Of a changed structure it is that of its changes. Not for those with whom it is shared.
    """
    body = store.structures.request(id)
    if body is None:
        raise NotFoundError(
            f"no request described the structure {id!r}: it was computed, read from a file, given in an "
            "assignment, or stored by an earlier version",
            field="id",
            value=id,
            allowed="structures of `POST /v1/structures` and `POST /v1/structures/{id}/changes`",
        )
    return dict(body)


@router.post(
    "/{id}/changes",
    status_code=status.HTTP_201_CREATED,
    response_model=StructureReply,
    summary="Change a structure",
)
def change_structure(
    id: IdPath, body: Annotated[ChangesIn, example(_CHANGES)], store: StoreDep, owner: OwnerDep
) -> Any:
    """Return a new structure with changed members, masses or springs; the first one stays as it is."""
    changed = change(store.structures.get(id), [change_in.to_domain() for change_in in body.changes])
    return _stored(store, changed, owner, body, structure_id=id)


@router.get(
    "/{id}/modes",
    summary="Get elastic modes",
    response_model=ModesReply,
    responses=csv_replies(_MODE_COLUMNS),
)
def get_modes(id: IdPath, store: StoreDep, as_csv: CsvWanted, count: Count = 10) -> Any:
    """Return the elastic modes of a structure, ascending in frequency; rigid-body modes are counted only."""
    basis, n_rigid_body = lowest_modes(as_modelled(store.structures.get(id)), count)
    columns = (
        range(1, len(basis.frequencies) + 1),
        basis.frequencies.tolist(),
        basis.loss_factors.tolist(),
    )
    rows = (dict(zip(_MODE_COLUMNS, row, strict=True)) for row in zip(*columns, strict=True))
    entry = store.structures.entry(id)
    return csv_or(lambda: modes_reply(basis, n_rigid_body, entry), _MODE_COLUMNS, rows, as_csv=as_csv)


@router.get(
    "/{id}/modes/arrays",
    response_class=Response,
    responses=array_tables.STRUCTURE_MODES,
    summary="Get modes with shapes",
)
def get_mode_arrays(id: IdPath, store: StoreDep, form: ArraysFormatDep, count: Count = 10) -> Response:
    """Return the elastic modes of a structure with mass-normalised shapes."""
    structure = store.structures.get(id)
    basis, _ = lowest_modes(as_modelled(structure), count)
    dofs = np.array([str(dof) for dof in structure.dofs])
    return form.reply({"frequencies": basis.frequencies, "shapes": basis.shapes, "dofs": dofs})


@router.get("/{id}/frf", response_class=Response, responses=array_tables.FRFS, summary="Compute FRFs")
def get_frf(id: IdPath, store: StoreDep, frf_query: FrfQuery, form: ArraysFormatDep) -> Response:
    """Return the exact frequency response functions (FRFs) of a structure, without rig and noise."""
    return form.reply(frf_query.arrays(store.structures.get(id)))


@router.get("/{id}/geometry", response_model=GeometryReply, summary="Get the geometry")
def get_geometry(id: IdPath, store: StoreDep) -> Any:
    """Return nodes, members and free degrees of freedom of a structure."""
    return geometry_reply(store.structures.get(id), store.structures.entry(id))


@router.get(
    "/{id}/geometry.uff",
    response_class=Response,
    responses=UFF,
    summary="Get the geometry as a universal file",
)
def get_geometry_uff(id: IdPath, store: StoreDep) -> Response:
    """Return nodes (dataset 15 or 2411) and lines (dataset 82) of a structure as a universal file."""
    structure, entry = store.structures.get(id), store.structures.entry(id)
    return uff_reply(uff_geometry.write(structure, origin(entry, f"structure {structure.name}")), id)


@router.post(
    "/{id}/synthetic-modes",
    status_code=status.HTTP_201_CREATED,
    response_model=ModalModelReply,
    summary="Make synthetic modes",
)
def make_synthetic_modes(
    id: IdPath, body: Annotated[SyntheticIn, example(_SYNTHETIC)], store: StoreDep, owner: OwnerDep
) -> Any:
    """Return modes of a structure at some degrees of freedom, with random errors, as a modal model."""
    system = as_modelled(store.structures.get(id))
    rng = np.random.default_rng(body.seed)
    model = synthetic_modes(system, body.count, body.places(), noise=body.noise.to_domain(), rng=rng)
    stored = store.modal_models.add(model, owner=owner, inputs={"structure_id": id}, seed=body.seed)
    return modal_model_reply(model, store.modal_models.entry(stored))


@router.post(
    "/{id}/expanded-modes",
    status_code=status.HTTP_201_CREATED,
    response_model=ExpandedReply,
    summary="Expand modes",
)
def expand_modes(
    id: IdPath, body: Annotated[ExpansionIn, example(_EXPANSION)], store: StoreDep, owner: OwnerDep
) -> Any:
    """Return measured modes expanded to all degrees of freedom of a structure."""
    reduction = reduction_in(body.reduction)
    measured = store.modal_models.get(body.modal_model_id)
    system = as_modelled(store.structures.get(id))
    check_size(system, len(measured.dofs), "modal_model_id")
    expansion = expand(system, measured, reduction)
    inputs = {"structure_id": id, "modal_model_id": body.modal_model_id}
    stored = store.modal_models.add(expansion.model, owner=owner, inputs=inputs)
    return modal_model_reply(
        expansion.model,
        store.modal_models.entry(stored),
        ExpandedReply,
        fit_residuals=expansion.residual.tolist(),
        rayleigh_frequencies=expansion.rayleigh.tolist(),
    )


@router.get(
    "/{id}/reduced",
    response_class=Response,
    responses=array_tables.REDUCED,
    summary="Reduce a structure",
)
def get_reduced(id: IdPath, store: StoreDep, reduced_query: ReducedQuery, form: ArraysFormatDep) -> Response:
    """Return mass and stiffness of a structure reduced to master degrees of freedom."""
    return form.reply(reduced_query.arrays(as_modelled(store.structures.get(id))))


add_routes(router, "structures", "structure")
