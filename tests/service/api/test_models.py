"""Plates and imported models over HTTP: measured, extracted, updated by groups; bad files by name."""

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import mmwrite

from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES

FILES = Path(__file__).parents[1] / "interchange" / "nastran"
PLATE = {
    "kind": "plate",
    "length": 0.6,
    "width": 0.4,
    "thickness": 0.004,
    "n_elements": [6, 4],
    "material": {"modulus": 2.09e11, "density": 7800.0},
}


def upload(service: Any, payload: bytes, **data: str) -> Any:
    files = {"file": ("model", payload)}
    return service.request("POST", "/v1/structures/import", files=files, data=data)


def modes_of(service: Any, structure: str, count: int = 6) -> Any:
    return service.get(f"/v1/structures/{structure}/modes", params={"count": count})


@pytest.fixture(scope="module")
def plate(service: Any) -> str:
    """An imported free plate, two per cent of loss."""
    law = '{"law": "structural", "stiffness_coefficient": 0.02}'
    reply = upload(service, (FILES / "plate.bdf").read_bytes(), name="bulk", damping=law)
    assert reply.status_code == 201, reply.text
    body = reply.json()
    assert (body["name"], body["n_nodes"], body["n_dofs"], body["members"]) == ("bulk", 35, 105, 24)
    assert body["groups"] == {"PSHELL 10": list(range(1, 25))}
    return str(body["id"])


def test_an_imported_plate_has_the_modes_of_one_described(service: Any, plate: str) -> None:
    described = modes_of(service, service.post("/v1/structures", PLATE)["id"])
    found = modes_of(service, plate)
    assert found["n_rigid_body"] == described["n_rigid_body"] == 3
    # large fields hold ten digits
    np.testing.assert_allclose(found["frequencies"], described["frequencies"], rtol=1e-6)
    np.testing.assert_allclose(found["loss_factors"], 0.02)


def test_a_plates_sides_are_held_as_asked(service: Any) -> None:
    held = service.post("/v1/structures", PLATE | {"edges": {"left": "clamped", "top": "simply_supported"}})
    # 5 nodes of 3, and 7 of 2 less the corner's
    assert held["n_dofs"] == 105 - 15 - 12
    assert modes_of(service, held["id"])["n_rigid_body"] == 0


def test_a_plate_may_have_many_elements(service: Any) -> None:
    fine = service.post("/v1/structures", PLATE | {"n_elements": [75, 50]})
    assert fine["n_dofs"] == 3 * 76 * 51
    # elements of 8 mm are within 0.2 % of half as large ones: errors fall with their squares, and the
    # coarse plate of 100 mm, 150 times the error, is within 10 %
    found = np.array(modes_of(service, fine["id"], 3)["frequencies"])
    coarse = np.array(modes_of(service, service.post("/v1/structures", PLATE)["id"], 3)["frequencies"])
    np.testing.assert_allclose(coarse, found, rtol=0.1)


def test_the_catalogue_has_a_plate(service: Any) -> None:
    assert service.post("/v1/structures", {"kind": "catalogue", "name": "plate"})["members"] == 96
    assert "plate" in [one["kind"] for one in service.get("/v1/catalog/structures")]


def test_a_test_of_an_imported_plate_gives_its_modes(service: Any, plate: str) -> None:
    responses = [f"{n}:+Z" for n in (1, 3, 5, 7, 15, 18, 21, 29, 32, 35)]
    analyser = {"frequency_max": 200.0, "n_lines": 801}
    rig = service.post("/v1/rigs", {"drive": "1:+Z", "responses": responses, "analyser": analyser})["id"]
    body = {"structure_id": plate, "rig_id": rig, "route": "expected", "seed": 1}
    test = service.result_of("/v1/measurements", body)
    asked = {"measurement_id": test, "method": "lscf", "bands": "auto"}
    model = service.get(f"/v1/modal-models/{service.result_of('/v1/modal-models', asked)}")
    found = np.array([mode["frequency"] for mode in model["modes"]])
    exact = np.array(modes_of(service, plate)["frequencies"])
    exact = exact[exact < 190.0]
    # ideal rig: what leakage of a periodic signal leaves is nothing, what the fit leaves is small
    near = np.abs(found[:, None] / exact - 1).min(axis=0)
    assert near.max() < 2e-3


def test_an_update_takes_groups_by_their_names(service: Any) -> None:
    bay = upload(service, (FILES / "bay_16.bdf").read_bytes()).json()
    horizontal = bay["groups"]["PBAR 1"]
    change = {"changes": [{"members": horizontal, "property": "modulus", "factor": 1.2}]}
    truth = service.post(f"/v1/structures/{bay['id']}/changes", change)["id"]
    body = {"count": 6, "dofs": [f"{n}:+{d}" for n in range(1, 31, 2) for d in "XY"]}
    modes = service.post(f"/v1/structures/{truth}/synthetic-modes", body)["id"]
    asked = {
        "structure_id": bay["id"],
        "modal_model_id": modes,
        "method": "inverse_eigensensitivity",
        "parameterisation": {"macros": list(bay["groups"]), "parts": ["stiffness"]},
    }
    found = service.get(f"/v1/updates/{service.result_of('/v1/updates', asked)}")
    assert found["converged"]
    stiffness = found["coefficients"]["stiffness"]
    # noise-free: to the tolerance of the iteration
    assert stiffness[str(horizontal[0])] == pytest.approx(1.2, abs=1e-4)
    assert stiffness[str(bay["groups"]["PBAR 3"][0])] == pytest.approx(1.0, abs=1e-4)
    refused = service.request(
        "POST", "/v1/updates", json=asked | {"parameterisation": {"macros": ["PBAR 9"]}}
    )
    assert refused.status_code == 422
    assert refused.json()["context"]["value"] == "PBAR 9"
    assert "PBAR 1" in refused.json()["context"]["allowed"]


def archive() -> bytes:
    system = assemble(STRUCTURES["cantilever"]())
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as target:
        for name in ("mass", "stiffness"):
            file = io.BytesIO()
            mmwrite(file, getattr(system, name), precision=17)
            target.writestr(f"{name}.mtx", file.getvalue())
        target.writestr("dofs.txt", "\n".join(map(str, system.dofs)))
    return out.getvalue()


def test_matrices_of_a_cantilever_have_its_frequencies(service: Any) -> None:
    own = service.post("/v1/structures", {"kind": "catalogue", "name": "cantilever"})["id"]
    imported = upload(service, archive()).json()
    assert imported["groups"] == {"model": [1]}
    # the same matrices: rounding
    np.testing.assert_allclose(
        modes_of(service, imported["id"])["frequencies"], modes_of(service, own)["frequencies"], rtol=1e-8
    )


@pytest.mark.parametrize(
    "path",
    [
        "geometry.uff",
        "modes/arrays",
        "frf?drive=1:%2BZ&responses=35:%2BZ",
        "reduced?kind=guyan&masters=1:%2BZ&masters=7:%2BZ&masters=29:%2BZ&masters=35:%2BZ",
    ],
)
def test_what_is_asked_of_a_structure_is_answered_of_an_imported_one(
    service: Any, plate: str, path: str
) -> None:
    reply = service.request("GET", f"/v1/structures/{plate}/{path}")
    assert reply.status_code == 200, reply.text


CHEXA = b"GRID,1\nCHEXA,1,2,3\n"
BAD = {
    "a card that is not read": (CHEXA, "CHEXA (1)"),
    "a picture": (b"\x89PNG\r\n", "holds no model"),
    "an empty file": (b"", "holds no model"),
    "an archive of nothing": (b"PK\x05\x06" + bytes(18), "holds no model"),
    "half a file": (archive()[:500], "not a zip archive"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_file_is_a_named_problem(service: Any, case: str) -> None:
    payload, words = BAD[case]
    reply = upload(service, payload)
    assert reply.status_code == 422
    assert reply.headers["content-type"] == "application/problem+json"
    assert words in reply.json()["detail"]
    assert reply.json()["context"]["field"]


STEEL = {"modulus": 2.09e11, "density": 7800.0}
SKIN = {"material": STEEL, "thickness": 0.004}
MESH = {
    "groups": {"thin": SKIN, "thick half": SKIN},
    "supports": [{"group": "left", "directions": ["Z", "RX", "RY"]}],
    "left_out": ["rib"],
    "length_unit": 0.001,
}


def upload_mesh(service: Any, **changed: Any) -> Any:
    payload = (FILES.parent / "mesh" / "gmsh_41.msh").read_bytes()
    return upload(service, payload, mesh=json.dumps(MESH | changed))


def test_a_mesh_becomes_a_plate_of_which_a_group_is_updated(service: Any) -> None:
    reply = upload_mesh(service)
    assert reply.status_code == 201, reply.text
    sheet = reply.json()
    assert {name: len(of) for name, of in sheet["groups"].items()} == {"thin": 20, "thick half": 40}
    assert sheet["n_dofs"] == 3 * (54 - 6)
    wrong = {"members": sheet["groups"]["thick half"], "property": "thickness", "factor": 1.25}
    truth = service.post(f"/v1/structures/{sheet['id']}/changes", {"changes": [wrong]})["id"]
    dofs = [f"{node}:+Z" for node in (2, 3, 4, 5, 20, 30, 40, 50)]
    modes = service.post(f"/v1/structures/{truth}/synthetic-modes", {"count": 5, "dofs": dofs})["id"]
    asked = {
        "structure_id": sheet["id"],
        "modal_model_id": modes,
        "method": "one_shot",
        "parameterisation": {"macros": ["thin", "thick half"], "parts": ["thickness"]},
    }
    update = service.get(f"/v1/updates/{service.result_of('/v1/updates', asked)}")
    assert [one["after"] for one in update["quantities"]] == pytest.approx([0.004, 0.005], rel=1e-6)


BAD_MESH: dict[str, tuple[dict[str, Any], str, str]] = {
    "an unknown group": ({"left_out": ["rib"], "groups": {"skin": SKIN}}, "no group 'skin'", "mesh"),
    "cells left over": ({"left_out": []}, "line (5), in rib", "mesh"),
    "neither bar nor plate": (
        {"groups": {"thin": {"material": STEEL}}},
        "Field required",
        "mesh.groups.thin",
    ),
    "no thickness": ({"groups": {"thin": SKIN | {"thickness": 0}}}, "positive", "thickness"),
    "an unknown direction": (
        {"supports": [{"group": "left", "directions": ["W"]}]},
        "'X', 'Y'",
        "mesh.supports",
    ),
    "no length": ({"length_unit": 0}, "positive", "length_unit"),
}


@pytest.mark.parametrize("case", BAD_MESH)
def test_a_bad_description_of_a_mesh_is_a_named_problem(service: Any, case: str) -> None:
    changed, words, field = BAD_MESH[case]
    reply = upload_mesh(service, **changed)
    assert reply.status_code == 422, reply.text
    assert words in reply.json()["detail"]
    assert reply.json()["context"]["field"].startswith(field)


def test_a_description_without_a_mesh_and_a_mesh_without_one_are_refused(service: Any) -> None:
    reply = upload(service, (FILES / "plate.bdf").read_bytes(), mesh=json.dumps(MESH))
    assert reply.status_code == 422
    assert "no mesh" in reply.json()["detail"]
    reply = upload(service, (FILES.parent / "mesh" / "gmsh_22.msh").read_bytes())
    assert reply.status_code == 422
    assert "thick half (40)" in reply.json()["context"]["allowed"]


def test_a_bad_damping_law_is_a_named_problem(service: Any) -> None:
    for law in ("{", '{"law": "none"}', '{"law": "structural", "stiffness_coefficient": -1}'):
        reply = upload(service, archive(), damping=law)
        assert reply.status_code == 422, law
        assert reply.json()["context"]["field"]


def test_a_plate_of_no_size_or_too_many_elements_is_refused(service: Any) -> None:
    for wrong in (
        {"thickness": 0.0},
        {"n_elements": [201, 200]},
        {"n_elements": [0, 4]},
        {"theory": "thin"},
    ):
        reply = service.request("POST", "/v1/structures", json=PLATE | wrong)
        assert reply.status_code == 422, wrong
        assert reply.json()["context"]["field"]


def test_effects_that_need_bars_are_refused_at_plates(service: Any, plate: str) -> None:
    rig = service.post("/v1/rigs", {"drive": "1:+Z", "responses": ["1:+Z", "7:+Z"]})["id"]
    for kind, at in (("joint_flexibility", "8:+RX"), ("misplaced_accelerometer", {"channels": ["7:+Z"]})):
        body = {"structure_id": plate, "rig_id": rig, "effects": [{"kind": kind, "at": at}]}
        reply = service.request("POST", "/v1/measurements", json=body)
        assert reply.status_code == 422, reply.text
        assert reply.json()["context"]["field"] == "at"


def test_what_hangs_on_a_plate_is_found_and_reported(service: Any, plate: str) -> None:
    rig = {
        "drive": "1:+Z",
        "responses": ["1:+Z", "7:+Z", "18:+Z", "32:+Z"],
        "analyser": {"frequency_max": 250.0, "n_lines": 126},
        "noise": {"force": 1e-3, "response": 1e-3},
    }
    hidden = {"kind": "extra_mass", "at": "20:+Z", "parameters": {"mass": 0.05}}
    asked = {"structure_id": plate, "rig_id": service.post("/v1/rigs", rig)["id"], "effects": [hidden]}
    test = service.result_of("/v1/measurements", asked | {"seed": 2})
    asked = {"structure_id": plate, "measurement_id": test, "suspects": ["extra_mass", "ground_spring"]}
    found = service.result_of("/v1/diagnoses", asked)
    reply = service.get(f"/v1/diagnoses/{found}")
    assert [(one["effect"]["kind"], one["effect"]["at"]) for one in reply["steps"]] == [
        ("extra_mass", "20:+Z")
    ]
    # a few parts in a thousand: noise of 1e-3 over a hundred lines, and three of four channels are fitted
    assert reply["steps"][0]["effect"]["parameters"]["mass"]["value"] == pytest.approx(0.05, rel=0.005)
    page = service.request("GET", f"/v1/diagnoses/{found}/report").text
    assert "between members" in page
