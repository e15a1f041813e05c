"""Models from files of several programs, for commands without a service."""

import json
from pathlib import Path
from typing import Any

import pytest

from modallab.api.from_files import Files, model_of
from modallab.core.errors import InvalidInputError

INTERCHANGE = Path(__file__).parents[1] / "interchange"
STEEL = {"modulus": 2.09e11, "density": 7800.0}
SKIN = {"material": STEEL, "thickness": 0.004}
GROUPS: dict[str, Any] = {
    "groups": {"thin": SKIN, "thick half": SKIN},
    "left_out": ["rib", "left"],
    "length_unit": 1e-3,
}
MESH = INTERCHANGE / "mesh" / "gmsh_41.msh"


def files(model: Path, mesh: Path | None = None) -> Files:
    return Files(model, Path("rig.json"), Path("frf.uff"), mesh)


def test_a_nastran_deck_is_a_model() -> None:
    plate = model_of(files(INTERCHANGE / "nastran" / "plate.bdf"))
    assert (len(plate.nodes), len(plate.all_members)) == (35, 24)


def test_a_mesh_is_a_model_once_its_groups_are_described(tmp_path: Path) -> None:
    groups = tmp_path / "groups.json"
    groups.write_text(json.dumps(GROUPS), encoding="utf-8")
    plate = model_of(files(MESH, groups))
    assert set(plate.groups) == {"thin", "thick half"}
    with pytest.raises(InvalidInputError, match="mesh"):
        model_of(files(MESH))


def test_a_model_in_json_is_a_body_of_the_api(tmp_path: Path) -> None:
    model = tmp_path / "model.json"
    model.write_text('{"kind": "catalogue", "name": "bay"}', encoding="utf-8")
    assert len(model_of(files(model)).all_members) > 0
    model.write_text("{", encoding="utf-8")
    with pytest.raises(InvalidInputError, match="not JSON"):
        model_of(files(model))
