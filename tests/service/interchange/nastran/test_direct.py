"""DMIG: matrices that pyNastran wrote have their frequencies, alone and beside elements."""

from pathlib import Path

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import assemble
from modallab.fe.members import MatrixElement
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import lowest_modes
from modallab.interchange.nastran.model import read
from tests.service.interchange.nastran import described

HERE = Path(__file__).parent
FREE = (HERE / "direct.bdf").read_text()

PAIR = """
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
DMIG,KAAX,0,6,2,0
DMIG,KAAX,1,1,,1,1,3.+3,,+
+,2,1,-1.+3
DMIG,KAAX,2,1,,2,1,1.+3
DMIG,MAAX,0,1,2,0
DMIG,MAAX,1,1,,1,1,2.
DMIG,MAAX,2,1,,2,1,5.-1
"""


def deck(*lines: str, bulk: str = PAIR) -> bytes:
    return "\n".join([*lines, "BEGIN BULK", bulk]).encode()


def frequencies(structure: Structure, count: int = 8) -> FloatArray:
    return lowest_modes(assemble(structure), count)[0].frequencies


def test_a_free_beam_of_matrices_has_its_frequencies_and_its_rigid_bodies() -> None:
    given = read(FREE.encode())
    own, n_rigid_body = lowest_modes(assemble(described.line()), 8)
    found, rigid = lowest_modes(assemble(given), 8)
    assert rigid == n_rigid_body == 2
    assert set(given.dofs) == set(described.line().dofs)
    assert given.nodes[7] == (1.5, 0.0, 0.0)
    # ten digits, of which a beam of six elements loses three between its highest and its lowest mode
    np.testing.assert_allclose(found.frequencies, own.frequencies, rtol=1e-7)


def test_a_square_matrix_in_small_fields_counts_both_sides() -> None:
    given = read((HERE / "direct_square.bdf").read_bytes())
    own = frequencies(described.held_line())
    # six digits of what is negative; the lowest eigenvalue is 3e4 times smaller than the highest
    np.testing.assert_allclose(frequencies(given), own, rtol=2e-3)


def test_by_hand_two_masses_on_springs() -> None:
    # K = [3, -1; -1, 1] 1e3, M = diag(2, 0.5): lambda = 1e3 (3.5 +- sqrt(3.5^2 - 8)) / 2
    root = np.sqrt(3.5**2 - 8)
    exact = np.sqrt(1e3 * np.array([3.5 - root, 3.5 + root]) / 2) / (2 * np.pi)
    np.testing.assert_allclose(frequencies(read(deck())), exact, rtol=1e-12)


def test_grid_points_may_be_left_out_where_nothing_else_needs_them() -> None:
    bare = "\n".join(line for line in PAIR.splitlines() if not line.startswith("GRID"))
    np.testing.assert_allclose(frequencies(read(deck(bulk=bare))), frequencies(read(deck())))


def test_supports_hold_matrices_too() -> None:
    held = read(deck(bulk=PAIR + "SPC1,1,1,1\n"))
    assert [str(dof) for dof in held.dofs] == ["2:+X"]
    assert frequencies(held)[0] == pytest.approx(np.sqrt(1e3 / 0.5) / (2 * np.pi))


def test_elements_are_beside_matrices_with_numbers_of_their_own() -> None:
    given = read(deck(bulk=PAIR + "CELAS2,7,5.+2,2,1\nCONM2,9,1,,1.5\nPARAM,WTMASS,2.\n"))
    assert {name: len(numbers) for name, numbers in given.groups.items()} == {
        "CELAS2": 1,
        "CONM2": 1,
        "DMIG": 1,
    }
    assert [member.number for member in given.all_members] == [7, 9, 10]
    system = assemble(given)
    at = [system.index(Dof(node, "X")) for node in (1, 2)]
    np.testing.assert_allclose(system.stiffness.toarray()[np.ix_(at, at)], [[3e3, -1e3], [-1e3, 1.5e3]])
    # a factor of masses is none of what a matrix has
    np.testing.assert_allclose(system.mass.toarray()[np.ix_(at, at)], [[2 + 2 * 1.5, 0], [0, 0.5]])


def test_case_control_chooses() -> None:
    other = PAIR.replace("KAAX", "STIFF").replace("MAAX", "INERTIA") + "DMIG,KAAX,0,6,2\nDMIG,BAAX,0,6,2\n"
    given = read(deck("K2GG = STIFF", "  M2GG=inertia", bulk=other))
    np.testing.assert_allclose(frequencies(given), frequencies(read(deck())))


def test_a_large_matrix_is_cut_into_members_of_two_nodes() -> None:
    n = 1200  # beyond a million numbers as one full matrix
    lines = ["DMIG,K,0,6,2", "DMIG,M,0,6,2"]
    for i in range(1, n + 1):
        lines += [f"DMIG,M,{i},1,,{i},1,1.", f"DMIG,K,{i},1,,{i},1,{'2.' if i < n else '1.'}"]
        lines += [f"DMIG,K,{i},1,,{i + 1},1,-1."] if i < n else []
    given = read(deck(bulk="\n".join(lines)))
    assert len(given.all_members) == 2 * n - 1
    assert all(isinstance(one, MatrixElement) and one.group == "DMIG" for one in given.all_members)
    # a chain held at one end: omega_r = 2 sin((2 r - 1) pi / (2 (2 n + 1)))
    exact = 2 * np.sin((2 * np.arange(1, 9) - 1) * np.pi / (2 * (2 * n + 1))) / (2 * np.pi)
    # rounding, times the highest eigenvalue over the lowest: 4 / 1.7e-6
    np.testing.assert_allclose(frequencies(given), exact, rtol=1e-9)


WRONG = {
    "complex": (PAIR.replace("KAAX,0,6,2", "KAAX,0,6,4"), [], "1 or 2: real", "DMIG KAAX"),
    "rectangular": (PAIR.replace("KAAX,0,6,2", "KAAX,0,9,2"), [], "1: square", "DMIG KAAX"),
    "no first card": (PAIR.replace("DMIG,KAAX,0,6,2,0", ""), [], "0 of a first card", "DMIG KAAX"),
    "a scalar point": (PAIR.replace("MAAX,2,1", "MAAX,2,0"), [], "scalar points", "DMIG MAAX"),
    "an unknown grid point": (PAIR.replace("GRID,2", "GRID,3"), [], "one or more", "DMIG"),
    "both sides of a symmetric one": (
        PAIR + "DMIG,KAAX,2,1,,1,1,-1.+3",
        [],
        "each entry once",
        "DMIG KAAX",
    ),
    "damping": (PAIR, ["B2GG = KAAX"], "K2GG and M2GG", "B2GG"),
    "a matrix that is not there": (PAIR, ["K2GG = KBB"], "KAAX, MAAX", "K2GG"),
    "several": (PAIR, ["K2GG = KAAX, KBB"], "KAAX, MAAX", "K2GG"),
    "nothing that chooses": (PAIR + "DMIG,KBB,0,6,2", [], "case control", "DMIG"),
    "what begins with neither": (PAIR + "DMIG,BAAX,0,6,2", [], "case control", "DMIG"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_not_read_is_refused_with_its_card(case: str) -> None:
    bulk, control, allowed, field = WRONG[case]
    with pytest.raises(InvalidInputError) as caught:
        read(deck(*control, bulk=bulk))
    assert allowed in str(caught.value.context["allowed"])
    assert caught.value.context["field"] == field
