"""Bulk data: files of pyNastran keep their frequencies, small decks have those of closed forms."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigvalsh

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import assemble
from modallab.fe.damping import StructuralDamping
from modallab.fe.members import Plate
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import lowest_modes
from modallab.interchange.nastran.model import read
from tests.service.interchange.nastran import described

HERE = Path(__file__).parent


def file(name: str) -> Structure:
    return read((HERE / f"{name}.bdf").read_bytes())


def modes(structure: Structure, count: int = 10) -> tuple[FloatArray, int]:
    basis, n_rigid_body = lowest_modes(assemble(structure), count)
    return basis.frequencies, n_rigid_body


def in_triangles() -> Structure:
    flat = described.free_plate()
    cut: list[Plate] = []
    for one in flat.non_bar_members:
        assert isinstance(one, Plate)
        a, b, c, d = one.nodes
        cut += [
            replace(one, number=len(cut) + i + 1, nodes=rim) for i, rim in enumerate(((a, b, c), (a, c, d)))
        ]
    return replace(flat, non_bar_members=tuple(cut))


FILES = {
    "bay_8": described.bay,  # small fields, CBAR
    "bay_16": described.bay,
    "loaded_bay": described.loaded_bay,  # double precision, CBEAM, CONM2, CELAS2, SPC1
    "plate": described.free_plate,  # CQUAD4
    "triangles": in_triangles,  # CTRIA3
}


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_pynastran_has_the_frequencies_of_what_it_was_written_from(name: str) -> None:
    own, given = FILES[name](), file(name)
    (frequencies, n_rigid_body), (found, rigid) = modes(own), modes(given)
    assert set(given.dofs) == set(own.dofs)
    assert rigid == n_rigid_body
    # small fields hold seven digits, large ones ten
    np.testing.assert_allclose(found, frequencies, rtol=1e-6 if name.endswith("8") else 1e-8)


def test_a_frame_that_may_leave_its_plane_keeps_the_frequencies_in_it() -> None:
    held = (HERE / "bay_16.bdf").read_text()
    free = read(held.replace("             345", " " * 16).encode())
    assert len(free.dofs) == 180
    found, n_rigid_body = modes(free, 60)
    assert n_rigid_body == 6
    in_plane = modes(described.bay(), 8)[0]
    # the plane of a frame is one of symmetry: rounding of a matrix twice as large
    assert np.abs(found[:, None] / in_plane - 1).min(axis=0).max() < 1e-8


def test_elements_are_grouped_by_their_properties() -> None:
    loaded = file("loaded_bay")
    sizes = {name: len(numbers) for name, numbers in loaded.groups.items()}
    assert sizes == {"PBEAM 1": 14, "PBEAM 2": 10, "PBEAM 3": 7, "CONM2": 1, "CELAS2": 1}
    assert loaded.groups["CONM2"] == (1001,)


BAR = """
GRID,1,,0.,0.,0.,,123456
GRID,2,,1.,0.,0.
MAT1,1,7.+10,,.3,2700.,,,.02
PBAR,5,1,4.-4,3.-9,5.-8,1.-8
CBAR,9,5,1,2,0.,1.,0.
"""


def test_free_fields_exponents_without_a_letter_and_losses_of_a_material() -> None:
    basis, n_rigid_body = lowest_modes(assemble(read(BAR.encode())), 6)
    assert n_rigid_body == 0
    # one element, clamped: omega^2 = 12.48 E I / (rho A L^4), the other root of 4x4 matrices is 1211.5
    # Przemieniecki (1968), section 12.3; to the digits printed
    line = 2700 * 4e-4
    for second in (3e-9, 5e-8):
        omega = np.sqrt(12.48 * 7e10 * second / line)
        assert np.abs(2 * np.pi * basis.frequencies / omega - 1).min() < 1e-3
    assert np.abs(2 * np.pi * basis.frequencies / np.sqrt(3 * 7e10 / 2700) - 1).min() < 1e-9
    np.testing.assert_allclose(basis.loss_factors, 0.02)


def test_small_and_large_fields_tabs_comments_and_case_control_are_read() -> None:
    text = """$ a bar
SOL 103
CEND
  SPC = 7
BEGIN BULK
GRID           1              0.      0.      0.
GRID*                  2                              1.              0.
*                     0.
SPC1           7  123456       1
SPC1           8       1       2
MAT1           1  7.+10               .3   2700.        $ aluminium
PBAR\t5\t1\t4.-4\t3.-9\t5.-8\t1.-8
CBAR           9       5       1       2      0.      1.      0.
PARAM   G       .04
ENDDATA
CHEXA          1
"""
    found = lowest_modes(assemble(read(text.encode())), 6)[0]
    free = lowest_modes(assemble(read(BAR.encode())), 6)[0]
    np.testing.assert_allclose(found.frequencies, free.frequencies, rtol=1e-12)


def test_a_loss_factor_of_all_elements_is_the_damping() -> None:
    without = BAR.replace(",,,.02", "")
    assert read((without + "PARAM,G,.04\n").encode()).damping == StructuralDamping(0.04)
    assert read(
        (without + "PARAM,G,.04\n").encode(), damping=StructuralDamping(0.1)
    ).damping == StructuralDamping(0.1)


def test_masses_in_other_units_are_scaled() -> None:
    heavy = (BAR + "PARAM,WTMASS,4.\n").encode()
    np.testing.assert_allclose(2 * modes(read(heavy), 6)[0], modes(read(BAR.encode()), 6)[0], rtol=1e-12)


def test_a_mass_off_its_grid_point_turns_with_it() -> None:
    # on a clamped bar that cannot bend, the eccentric mass is held by torsion alone: m e^2 omega^2 = G J / L
    text = """
GRID,1,,0.,0.,0.,,123456
GRID,2,,1.,0.,0.,,12356
MAT1,1,7.+10,,.3,1.-6
PBAR,5,1,4.-4,3.-9,5.-8,1.-8
CBAR,9,5,1,2,0.,1.,0.
CONM2,10,2,,2.,0.,.3,.4
"""
    found = read(text.encode())
    omega = np.sqrt(7e10 / 2.6 * 1e-8 / (2.0 * 0.25))
    # beside the bar's own inertia of 1e-14
    np.testing.assert_allclose(2 * np.pi * modes(found, 1)[0], omega, rtol=1e-9)


def test_springs_between_points_and_to_the_ground() -> None:
    text = """
GRID,1
GRID,2,,1.
CONM2,1,1,,1.
CONM2,2,2,,1.
CELAS2,3,100.,1,1,2,1
CELAS1,4,6,1,1,0,0
PELAS,6,300.
"""
    squares = eigvalsh([[400.0, -100.0], [-100.0, 100.0]])
    np.testing.assert_allclose(modes(read(text.encode()), 2)[0], np.sqrt(squares) / (2 * np.pi), rtol=1e-12)


def test_rods_pull_and_leave_what_they_do_not_hold() -> None:
    text = """
GRID,1,,0.,0.,0.,,123
GRID,2,,2.,0.,0.,,123
GRID,3,,1.,1.,0.
MAT1,1,7.+10,,.3,2700.
PROD,2,1,1.-4
CROD,1,2,1,3
CONROD,2,2,3,1,1.-4
"""
    found = read(text.encode())
    assert {str(dof) for dof in found.dofs} == {"3:+X", "3:+Y"}
    # of length sqrt 2, across one another: together k in every direction, and a third of their mass
    stiffness, mass = 7e10 * 1e-4 / np.sqrt(2), 2 * 2700 * 1e-4 * np.sqrt(2) / 3
    np.testing.assert_allclose(2 * np.pi * modes(found, 2)[0], np.sqrt(stiffness / mass), rtol=1e-9)


@pytest.mark.parametrize(
    ("line", "area", "second"),
    [
        ("PBARL,5,1,,ROD,,,,,+\n+,.02", np.pi * 4e-4, np.pi * 0.02**4 / 4),
        ("PBARL,5,1,,TUBE,,,,,+\n+,.02,.01", np.pi * 3e-4, np.pi * (0.02**4 - 0.01**4) / 4),
        ("PBARL,5,1,,BAR,,,,,+\n+,.02,.03", 6e-4, 0.02 * 0.03**3 / 12),
        ("PBARL,5,1,,BOX,,,,,+\n+,.04,.05,.002,.003", 4.36e-4, (0.04 * 0.05**3 - 0.034 * 0.046**3) / 12),
    ],
)
def test_sections_by_their_shape_bend_as_by_their_numbers(line: str, area: float, second: float) -> None:
    plain = BAR.replace("PBAR,5,1,4.-4,3.-9,5.-8,1.-8", f"PBAR,5,1,{area:.9f},{second:.6e},5.-8,1.-8")
    shaped = BAR.replace("PBAR,5,1,4.-4,3.-9,5.-8,1.-8", line)
    bent = np.sqrt(12.48 * 7e10 * second / (2700 * area)) / (2 * np.pi)
    for text in (plain, shaped):
        # to the digits of 12.48
        assert np.abs(modes(read(text.encode()), 6)[0] / bent - 1).min() < 1e-3


def swapped(old: str, new: str) -> str:
    assert old in BAR
    return BAR.replace(old, new)


MASS = "CONM2,10,2,,2."
CHOSEN = f"SPC = 5\nBEGIN BULK\n{BAR}SPC1,1,123,2\n"
WRONG = {
    "unknown cards": (
        BAR + "CHEXA,20,1,1,2\nCHEXA,21,1,1,2\nRBE2,22,1,123,2",
        r"not read: CHEXA \(2\), RBE2 \(1\)",
    ),
    "another file": (BAR + "INCLUDE '/etc/hostname'", "asks for another file"),
    "no grid points": ("MAT1,1,7.+10,,.3", "no grid points"),
    "no elements": ("GRID,1\nGRID,2", "a model needs"),
    "a continuation of nothing": ("+,1.,2.\nGRID,1", "continues no card"),
    "no number": (swapped("4.-4", "four"), "PBAR in line 5, field 4: 'four'"),
    "a number beyond all": (swapped("4.-4", "4.+40"), "PBAR in line 5, field 4"),
    "no grid point": (swapped("CBAR,9,5,1,2", "CBAR,9,5,1,3"), "CBAR in line 6, field 5: '3'"),
    "no property": (swapped("CBAR,9,5", "CBAR,9,6"), "CBAR in line 6, field 3: '6'"),
    "no material": (swapped("PBAR,5,1", "PBAR,5,2"), "PBAR in line 5, field 3: '2'"),
    "half a material": (swapped("7.+10,,.3", "7.+10,,"), "MAT1 in line 4, field 3"),
    "no shear modulus": (swapped("7.+10,,.3", "7.+10,0."), "MAT1 in line 4, field 4"),
    "shear of no area": (
        swapped("4.-4,3.-9,5.-8,1.-8", "0.,3.-9,5.-8,1.-8\n+\n+,1.,1."),
        "PBAR in line 5, field 4",
    ),
    "a number of no element": (BAR + "CONM2,-3,2,,2.", "CONM2 in line 7, field 2"),
    "negative density": (swapped("2700.", "-2700."), "MAT1 in line 4, field 6"),
    "a vector along the bar": (swapped("0.,1.,0.", "1.,0.,0."), "CBAR in line 6, field 6"),
    "no length": (swapped("GRID,2,,1.,0.,0.", "GRID,2,,0.,0.,0."), "CBAR in line 6, field 4"),
    "a pin": (swapped("0.,1.,0.", "0.,1.,0.\n+,456"), "CBAR in line 6, field 10"),
    "a product of inertia": (swapped("1.-8", "1.-8\n+\n+,,,1.-9"), "PBAR in line 5, field 20"),
    "two elements of a number": (BAR + "CONM2,9,2,,2.", "two elements have number 9, in lines 6 and 7"),
    "two grid points of a number": (BAR + "GRID,2", "two grid points have number 2"),
    "other axes": (BAR + "CORD2R,4\nGRID,3,4", "GRID in line 8, field 3"),
    "a line too long": (swapped("0.,1.,0.", "0.,1.,0.,,456"), "line 6 has more than 8 fields"),
    "directions": (swapped("123456", "1237"), "GRID in line 2, field 8"),
    "nothing to hold": (BAR + "SPC1,1,123,77", "no grid point 77"),
    "a set that there is not": (CHOSEN, "no set of constraints 5"),
    "a sum of a set that there is not": (CHOSEN + "SPCADD,5,1,6", "no set of constraints 6"),
    "a sum of itself": (CHOSEN + "SPCADD,5,5,1", "no set of constraints 5"),
    "several sets": (BAR + "SPC1,1,1,2\nSPC1,2,2,2", "several sets of constraints"),
    "a prescribed motion": (BAR + "SPC,1,2,1,.5", "SPC in line 7, field 5"),
    "a negative mass": (BAR + "CONM2,10,2,,-2.", "CONM2 in line 7, field 5"),
    "no mass": (swapped("2700.", "0."), "carry no mass"),
    "all held": (BAR + "SPC1,1,123456,2", "hold every degree"),
    "a spring of nothing": (BAR + "CELAS2,11,100.", "joins nothing"),
    "a spring of two directions": (BAR + "CELAS2,11,100.,2,12", "CELAS2 in line 7, field 5"),
    "no bulk data": ("what is this?", "line 1 holds no card|no grid points|not read"),
    "letters": ("GRID,1\nMAT1,1,é", "no character of bulk data"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_read_is_told_by_card_line_and_field(case: str) -> None:
    text, message = WRONG[case]
    with pytest.raises(InvalidInputError, match=message) as caught:
        read(text.encode())
    assert caught.value.context["field"]


SHELL = """
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.,0.
GRID,4,,0.,1.,0.
MAT1,1,7.+10,,.3,2700.
PSHELL,5,1,.01,1,,1
CQUAD4,9,5,1,2,3,4
"""
WRONG_SHELL = {
    "no thickness": ("PSHELL,5,1,.01", "PSHELL,5,1,0.", "PSHELL in line 7, field 4"),
    "a sandwich": ("1,,1\n", "1,12.,1\n", "PSHELL in line 7, field 6"),
    "an offset": ("1,2,3,4", "1,2,3,4,,.1", "CQUAD4 in line 8, field 9"),
    "crossed": ("1,2,3,4", "1,2,4,3", "CQUAD4 in line 8, field 4"),
    "warped": ("GRID,3,,1.,1.,0.", "GRID,3,,1.,1.,.1", "CQUAD4 in line 8, field 4"),
    "a bar's property": ("PSHELL,5,1,.01,1,,1", "PROD,5,1,.01", "CQUAD4 in line 8, field 3"),
}


@pytest.mark.parametrize("case", WRONG_SHELL)
def test_what_a_shell_cannot_be_is_told(case: str) -> None:
    old, new, message = WRONG_SHELL[case]
    with pytest.raises(InvalidInputError, match=message):
        read(SHELL.replace(old, new).encode())


def test_a_shell_in_space_is_free_in_six_ways() -> None:
    shell = read(SHELL.encode())
    assert len(shell.dofs) == 24
    assert modes(shell, 1)[1] == 6


def test_a_shell_without_bending_has_no_motion_across() -> None:
    membrane = read(SHELL.replace("1,,1\n", "\n").encode())
    assert {dof.direction for dof in membrane.dofs} == {"X", "Y", "RZ"}
