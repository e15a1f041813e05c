"""What the client sends of models: plates, files, matrices full and sparse."""

import io
import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csc_array

from modallab_client import ModalLab
from tests.client.fake import FakeService

ABOUT = {"id": "s1", "n_nodes": 2, "n_dofs": 2, "members": 1, "name": "", "groups": {"a": [1]}}
SPRING = np.array([[1.0, -1.0], [-1.0, 1.0]])


def sent_arrays(service: FakeService) -> dict[str, np.ndarray]:
    content = service.requests[-1].content
    with np.load(io.BytesIO(content[content.index(b"PK\x03\x04") :])) as archive:
        return dict(archive)


def test_a_plate_is_asked_for_by_keywords(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/structures", ABOUT)
    lab.structures.plate(
        length=0.6,
        width=0.4,
        thickness=0.004,
        n_elements=(12, 8),
        material={"modulus": 2e11, "density": 7800.0},
        edges={"left": "clamped"},
    )
    body = json.loads(service.requests[0].content)
    assert (body["kind"], body["n_elements"], body["edges"]) == ("plate", [12, 8], {"left": "clamped"})
    assert "supports" not in body


def test_a_file_goes_with_its_name_and_damping(lab: ModalLab, service: FakeService, tmp_path: Path) -> None:
    service.on("POST /v1/structures/import", ABOUT)
    (tmp_path / "bay.bdf").write_bytes(b"GRID,1\n")
    given = lab.structures.upload(
        tmp_path / "bay.bdf", name="bay", damping={"law": "modal", "loss_factors": 0.01}
    )
    assert given.groups == {"a": (1,)}
    assert hash(given) is not None
    content = service.requests[0].content
    assert b'filename="bay.bdf"' in content
    assert b'{"law": "modal", "loss_factors": 0.01}' in content
    lab.structures.upload(b"GRID,1\n")
    assert b"damping" not in service.requests[1].content


def test_an_output4_file_goes_with_its_degrees_of_freedom(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/structures/import", ABOUT)
    lab.structures.upload(b"matrices", dofs=["1:+X", "2:+X"])
    content = service.requests[0].content
    with zipfile.ZipFile(io.BytesIO(content[content.index(b"PK\x03\x04") :])) as archive:
        assert archive.read("dofs.txt") == b"1:+X\n2:+X"
        assert archive.read("model.op4") == b"matrices"


def test_a_mesh_goes_with_what_its_groups_are_made_of(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/structures/import", ABOUT)
    skin = {"material": {"modulus": 2e11, "density": 7800.0}, "thickness": 0.004}
    lab.structures.import_mesh(b"$MeshFormat", groups={"skin": skin}, left_out=["line"], length_unit=1e-3)
    content = service.requests[0].content
    told = json.loads(content[content.index(b'{"groups"') :].split(b"\r\n")[0])
    assert told == {"groups": {"skin": skin}, "supports": [], "left_out": ["line"], "length_unit": 1e-3}


@pytest.mark.parametrize("sparse", [False, True])
def test_matrices_go_as_triplets(lab: ModalLab, service: FakeService, sparse: bool) -> None:
    service.on("POST /v1/structures/import", ABOUT)
    mass, stiffness = (csc_array(one) if sparse else one for one in (np.eye(2), 3 * SPRING))
    lab.structures.import_matrices(
        dofs=["1:+X", "2:+X"], mass=mass, stiffness=stiffness, coordinates={1: [0, 0, 0], 2: [1, 0, 0]}
    )
    sent = sent_arrays(service)
    assert sent["dofs"].tolist() == ["1:+X", "2:+X"]
    assert sent["mass_values"].tolist() == [1.0, 1.0]
    rebuilt = np.zeros((2, 2))
    rebuilt[sent["stiffness_rows"], sent["stiffness_columns"]] = sent["stiffness_values"]
    np.testing.assert_array_equal(rebuilt, 3 * SPRING)
    assert sent["coordinates"].tolist() == [[0, 0, 0], [1, 0, 0]]


def test_groups_go_with_their_names(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/structures/import", ABOUT)
    none = np.zeros((2, 2))
    lab.structures.import_matrices(
        dofs=["1:+X", "2:+X"], groups={"masses": (np.eye(2), none), "spring": (none, SPRING)}
    )
    sent = sent_arrays(service)
    assert sent["groups"].tolist() == ["masses", "spring"]
    assert sent["mass_groups"].tolist() == [0, 0]
    assert sent["stiffness_groups"].tolist() == [1, 1, 1, 1]


def test_neither_matrices_nor_groups_is_no_model(lab: ModalLab) -> None:
    with pytest.raises(ValueError, match="mass and stiffness, or by groups"):
        lab.structures.import_matrices(dofs=["1:+X"])
    with pytest.raises(ValueError, match="two dimensions"):
        lab.structures.import_matrices(dofs=["1:+X"], mass=[1.0], stiffness=[1.0])
