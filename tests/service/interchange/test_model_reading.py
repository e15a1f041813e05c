"""Models as npz and Matrix Market: read as they were, and nothing believed that was not checked."""

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import mmwrite

from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import Assembly, assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import lowest_modes
from modallab.interchange.model_reading import read_model
from tests.service.interchange.nastran import described

BAY = STRUCTURES["bay"]()
SYSTEM = assemble(BAY)
PARTS = Assembly(BAY)
DOFS = np.array([str(dof) for dof in BAY.dofs])
ENOUGH = 10_000_000


def npz(**arrays: Any) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def archive(**files: bytes) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as target:
        for name, content in files.items():
            target.writestr(name.replace("__", "/").replace("_", "."), content)
    return file.getvalue()


def market(matrix: Any) -> bytes:
    file = io.BytesIO()
    mmwrite(file, matrix, precision=17)
    return file.getvalue()


def read(payload: bytes, largest: int = ENOUGH, **given: Any) -> Structure:
    return read_model(io.BytesIO(payload), largest=largest, **given)


def triplets(name: str, matrix: Any) -> dict[str, Any]:
    entries = matrix.tocoo()
    return {f"{name}_rows": entries.row, f"{name}_columns": entries.col, f"{name}_values": entries.data}


ELEMENTS = {
    "element_dofs": PARTS.rows,
    "element_mass": PARTS.mass,
    "element_stiffness": PARTS.axial + PARTS.bending,
    "element_bending": PARTS.bending,
    "element_groups": np.array(["low" if m.number < 8 else "rest" for m in BAY.members]),
}
WHOLE = {"mass": SYSTEM.mass.toarray(), "stiffness": SYSTEM.stiffness.toarray()}
SPARSE = triplets("mass", SYSTEM.mass) | triplets("stiffness", SYSTEM.stiffness)
TABLE = "\n".join(DOFS).encode()
MARKET = {
    "dofs_txt": TABLE,
    "mass_mtx": market(SYSTEM.mass),
    "stiffness_mtx": market(SYSTEM.stiffness),
}
GROUPED = {
    "dofs_txt": TABLE,
    "frame__mass_mtx": MARKET["mass_mtx"],
    "frame__stiffness_mtx": MARKET["stiffness_mtx"],
}
HERE = Path(__file__).parent / "nastran"
LINE = described.line()
OP4 = (HERE / "bigmat_text.op4").read_bytes()
LINE_TABLE = "\n".join(map(str, LINE.dofs)).encode()


FORMS = {
    "full": npz(dofs=DOFS, **WHOLE),
    "sparse": npz(dofs=DOFS, **SPARSE),
    "elements": npz(dofs=DOFS, **ELEMENTS),
    "elements and whole": npz(dofs=DOFS, **ELEMENTS, **WHOLE),
    "Matrix Market": archive(**MARKET),
    "Matrix Market in groups": archive(**GROUPED),
}


@pytest.mark.parametrize("form", FORMS)
def test_a_model_has_the_modes_that_it_had(form: str) -> None:
    own, n_rigid_body = lowest_modes(SYSTEM, 8)
    found, rigid = lowest_modes(assemble(read(FORMS[form])), 8)
    assert rigid == n_rigid_body
    # all digits were written: rounding, times the highest eigenvalue over the lowest
    np.testing.assert_allclose(found.frequencies, own.frequencies, rtol=1e-8)


def test_elements_keep_their_numbers_groups_and_parts() -> None:
    numbers = np.array([m.number + 100 for m in BAY.members])
    given = read(npz(dofs=DOFS, **ELEMENTS, element_numbers=numbers))
    assert [m.number for m in given.all_members] == numbers.tolist()
    assert given.groups["low"] == tuple(range(101, 108))
    # what is left of a difference of a sum
    np.testing.assert_allclose(Assembly(given).axial, PARTS.axial, atol=1e-9 * PARTS.bending.max())
    np.testing.assert_array_equal(Assembly(given).bending, PARTS.bending)


def test_places_name_and_damping_go_along() -> None:
    nodes = np.array(list(BAY.nodes))
    places = np.array([BAY.nodes[n] for n in nodes])
    law = StructuralDamping(0.02)
    given = read(npz(dofs=DOFS, nodes=nodes, coordinates=places, **WHOLE), damping=law, name="mine")
    assert given.nodes[13] == (5.0, 3.0, 0.0)
    assert (given.damping, given.name) == (law, "mine")


def test_a_free_model_without_places_has_its_rigid_bodies() -> None:
    assert lowest_modes(assemble(read(FORMS["sparse"])), 1)[1] == 3


@pytest.mark.parametrize("name", ["model_op4", "frame__any_op4", "mass_op4"])
def test_one_file_of_nastran_holds_both_matrices_by_their_names(name: str) -> None:
    given = read(archive(dofs_txt=LINE_TABLE, **{name: OP4}))
    own, n_rigid_body = lowest_modes(assemble(LINE), 8)
    found, rigid = lowest_modes(assemble(given), 8)
    assert rigid == n_rigid_body
    # all digits were written
    np.testing.assert_allclose(found.frequencies, own.frequencies, rtol=1e-8)


SHORT = {name: value for name, value in SPARSE.items() if name != "mass_rows"}
WRONG: dict[str, tuple[bytes, str]] = {
    "nothing": (b"", "holds no model"),
    "words": (b"\x00\x01 no model", "holds no model"),
    "FRFs": (npz(freq=np.ones(3), values=np.ones(3)), "holds no model"),
    "half an archive": (FORMS["full"][:2000], "not a zip archive"),
    "half a matrix": (
        archive(**{**MARKET, "mass_mtx": MARKET["mass_mtx"][:400]}),
        "no Matrix Market file|fit",
    ),
    "no mass": (npz(dofs=DOFS, stiffness=WHOLE["stiffness"]), "lacks mass_rows"),
    "no table": (archive(mass_mtx=b"", stiffness_mtx=b""), "lacks dofs.txt"),
    "a short table": (archive(**{**MARKET, "dofs_txt": b"1:+X 1:+Y"}), "does not fit the degrees"),
    "no directions": (
        npz(dofs=np.array(["1", "2"]), mass=np.eye(2), stiffness=np.eye(2)),
        "no degree|not a degree",
    ),
    "another shape": (
        npz(dofs=DOFS, mass=np.eye(3), stiffness=WHOLE["stiffness"]),
        "mass has the wrong shape",
    ),
    "complex": (npz(dofs=DOFS, mass=1j * WHOLE["mass"], stiffness=WHOLE["stiffness"]), "mass is not real"),
    "NaN": (npz(dofs=DOFS, mass=np.nan * WHOLE["mass"], stiffness=WHOLE["stiffness"]), "not finite"),
    "a row of a triplet": (npz(dofs=DOFS, **SHORT), "lacks mass_rows"),
    "triplets": (npz(dofs=DOFS, **{**SPARSE, "mass_rows": SPARSE["mass_rows"][1:]}), "not of one length"),
    "places beyond": (
        npz(dofs=DOFS, **{**SPARSE, "mass_rows": 1000 + SPARSE["mass_rows"]}),
        "mass_rows holds",
    ),
    "halves of places": (
        npz(dofs=DOFS, **{**ELEMENTS, "element_dofs": PARTS.rows + 0.5}),
        "element_dofs holds",
    ),
    "one group for all": (npz(dofs=DOFS, **{**ELEMENTS, "element_groups": np.array(["a"])}), "wrong length"),
    "another sum": (npz(dofs=DOFS, **ELEMENTS, mass=2 * WHOLE["mass"]), "do not add up to the mass"),
    "nodes without a place": (
        npz(dofs=DOFS, nodes=[1], coordinates=[[0.0, 0.0]], **WHOLE),
        "node 2 has no place",
    ),
    "OUTPUT4 of one name with two matrices": (
        archive(dofs_txt=LINE_TABLE, a_op4=OP4, b_op4=OP4),
        "holds the stiffness again",
    ),
    "OUTPUT4 of names that say nothing": (
        archive(dofs_txt=LINE_TABLE, a_op4=OP4.replace(b"KXX", b"BXX")),
        "it is open what matrix BXX is",
    ),
    "OUTPUT4 without a table": (archive(a_op4=OP4), "lacks dofs.txt"),
    "OUTPUT4 of another size": (archive(dofs_txt=TABLE, a_op4=OP4), "does not fit the degrees"),
    "OUTPUT4 alone": (OP4, "holds no model"),
    "objects": (npz(dofs=np.array([{}], object), **WHOLE), "cannot read"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_no_model_is_refused_by_name(case: str) -> None:
    payload, message = WRONG[case]
    with pytest.raises(InvalidInputError, match=message) as caught:
        read(payload)
    assert caught.value.context["field"]


@pytest.mark.parametrize("form", ["full", "Matrix Market"])
def test_more_than_there_is_room_for_is_refused(form: str) -> None:
    with pytest.raises(InvalidInputError, match=r"too large|not a zip archive"):
        read(FORMS[form], largest=20_000)


def test_a_matrix_that_claims_to_be_huge_takes_no_room() -> None:
    claim = b"%%MatrixMarket matrix array real general\n2000000000 2000000000\n1.0\n"
    with pytest.raises(InvalidInputError, match="does not fit"):
        read(archive(**{**MARKET, "mass_mtx": claim}))
