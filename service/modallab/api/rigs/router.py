"""Rigs: the log books of tests."""

from typing import Annotated, Any

from fastapi import APIRouter, Query, status

from modallab.api.deps import Id, IdPath, OwnerDep, StoreDep
from modallab.api.examples import example
from modallab.api.offloading.route import OffloadedRoute
from modallab.api.rigs.replies import ChecksReply, RigChecks, RigReply, rig_reply, rig_request
from modallab.api.rigs.schemas import RigIn
from modallab.api.shelves import add_routes
from modallab.rig.checks import check_result, checks

router = APIRouter(prefix="/rigs", tags=["rigs"], route_class=OffloadedRoute)

_RIG = {
    "drive": "1:+Y",
    "responses": ["1:+Y", "3:+Y", "5:+Y"],
    "exciter": {"kind": "shaker", "armature_mass": 0.02},
    "force_transducer": {"mass_below": 0.01},
    "accelerometers": {"mass": 0.02, "roving": True},
    "analyser": {"frequency_max": 800.0, "n_lines": 401, "averages": 100},
    "noise": {"force": 1e-3, "response": 1e-3},
}


@router.post("", status_code=status.HTTP_201_CREATED, response_model=RigReply, summary="Declare a rig")
def create_rig(body: Annotated[RigIn, example(_RIG)], store: StoreDep, owner: OwnerDep) -> Any:
    """Return a rig: the declaration of a test set-up. Parts left out are ideal."""
    setup = body.to_domain()
    return rig_reply(setup, store.rigs.entry(store.rigs.add(setup, owner=owner)))


@router.get("/{id}", response_model=RigReply, summary="Get a rig")
def get_rig(id: IdPath, store: StoreDep) -> Any:
    """Return a rig as declared, with defaults filled in."""
    return rig_reply(store.rigs.get(id), store.rigs.entry(id))


@router.get("/{id}/body", summary="Get the body that declares a rig")
def get_rig_body(id: IdPath, store: StoreDep) -> dict[str, Any]:
    """Return the body of `POST /v1/rigs` that declares the same rig, with defaults filled in."""
    return rig_request(store.rigs.get(id))


@router.get("/{id}/checks", response_model=ChecksReply, summary="Check a rig on a structure")
def get_checks(
    id: IdPath, structure_id: Annotated[Id, Query(description="what the rig tests")], store: StoreDep
) -> Any:
    """Return rules of good testing, evaluated for a rig on a structure."""
    evaluated = checks(store.structures.get(structure_id), store.rigs.get(id))
    return RigChecks(id, structure_id, tuple(check_result(check) for check in evaluated))


add_routes(router, "rigs", "rig")
