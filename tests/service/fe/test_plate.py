"""Plates: exact frequencies, the rate at which the mesh gets there, patches, rigid bodies."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import StructureError
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.members import Plate
from modallab.fe.plate import Edge, Holding, plate
from modallab.fe.structure import Material, Structure
from modallab.fe.synthetic_modes import lowest_modes

STEEL = Material(modulus=2.09e11, density=7800.0)
LENGTH, WIDTH = 0.6, 0.4
HELD = dict.fromkeys(Edge, Holding.SIMPLY_SUPPORTED)


def supported(thickness: float, n: int) -> Structure:
    return plate(
        length=LENGTH,
        width=WIDTH,
        thickness=thickness,
        n_elements=(3 * n // 2, n),
        material=STEEL,
        edges=HELD,
    )


def frequencies(structure: Structure, count: int) -> FloatArray:
    return lowest_modes(assemble(structure), count)[0].frequencies


def wave_numbers(count: int) -> FloatArray:
    """Squares of the wave numbers of a simply supported rectangle, 1/m^2, the lowest."""
    every = [(np.pi * m / LENGTH) ** 2 + (np.pi * n / WIDTH) ** 2 for m in range(1, 9) for n in range(1, 9)]
    return np.sort(every)[:count]


def kirchhoff(thickness: float, count: int) -> FloatArray:
    """Navier's frequencies of a thin plate, Hz: Timoshenko, Vibration Problems in Engineering (1937)."""
    rigidity = STEEL.modulus * thickness**3 / 12 / (1 - STEEL.poisson_ratio**2)
    return np.asarray(wave_numbers(count) * np.sqrt(rigidity / (STEEL.density * thickness)) / (2 * np.pi))


def mindlin(thickness: float, count: int) -> FloatArray:
    """The same of a plate that shears, Hz: Mindlin, Journal of Applied Mechanics 18 (1951) 31-38."""
    q = wave_numbers(count)
    line, turned = STEEL.density * thickness, STEEL.density * thickness**3 / 12
    bent = STEEL.modulus * thickness**3 / 12 / (1 - STEEL.poisson_ratio**2)
    sheared = 5 / 6 * STEEL.shear_modulus * thickness
    a, c = line * turned, sheared * bent * q**2
    b = line * (bent * q + sheared) + turned * sheared * q
    return np.asarray(np.sqrt(2 * c / (b + np.sqrt(b**2 - 4 * a * c))) / (2 * np.pi))


@pytest.mark.parametrize("thickness", [4e-4, 4e-3, 4e-2])
def test_frequencies_come_to_the_exact_ones_of_a_plate_that_shears_with_the_square_of_the_mesh(
    thickness: float,
) -> None:
    exact = mindlin(thickness, 4)
    off = [frequencies(supported(thickness, n), 4) / exact - 1 for n in (8, 16)]
    # second order: a quarter, but for terms of fourth order, 0.07 of the second at the coarser mesh
    np.testing.assert_allclose(off[0] / off[1], 4.0, rtol=0.07)
    # what is left once that order is taken out: of fourth order, the square of the error
    best = (4 * off[1] - off[0]) / 3
    assert np.abs(best).max() < np.abs(off[0]).max() ** 2


def test_a_thin_plate_is_kirchhoffs_and_does_not_lock() -> None:
    thickness = 4e-5  # a ten-thousandth of the width: shear takes (pi t / b)^2 / 5 = 2e-8 of a frequency
    exact = kirchhoff(thickness, 4)
    coarse, fine = (frequencies(supported(thickness, n), 4) for n in (8, 16))
    refined = (4 * fine - coarse) / 3
    # fourth order, the square of the coarser mesh's 0.07
    np.testing.assert_allclose(refined, exact, rtol=0.005)
    # the fundamental one's own: 0.015 squared
    assert refined[0] == pytest.approx(exact[0], rel=2.2e-4)


def in_triangles(structure: Structure) -> Structure:
    """Each rectangle cut in two."""
    cut: list[Plate] = []
    for one in structure.non_bar_members:
        assert isinstance(one, Plate)
        a, b, c, d = one.nodes
        for rim in ((a, b, c), (a, c, d)):
            cut.append(replace(one, number=len(cut) + 1, nodes=rim))
    return replace(structure, non_bar_members=tuple(cut))


def test_triangles_come_to_the_frequencies_of_a_thin_plate_with_the_square_of_the_mesh() -> None:
    exact = kirchhoff(4e-3, 4)
    off = [frequencies(in_triangles(supported(4e-3, n)), 4) / exact - 1 for n in (8, 16)]
    # second order: a quarter; the inertia of turning normals, which the exact ones lack, takes 3e-5
    np.testing.assert_allclose(off[0] / off[1], 4.0, rtol=0.07)


def bent(structure: Structure, curvature: Sequence[float]) -> dict[Dof, float]:
    """w = (a x^2 + b y^2)/2 + c x y with normals that stay normal, at every degree of freedom."""
    a, b, c = curvature
    out = {}
    for node, (x, y) in structure.nodes.items():
        out[Dof(node, "Z")] = (a * x**2 + b * y**2) / 2 + c * x * y
        out[Dof(node, "RX")] = b * y + c * x  # w,y
        out[Dof(node, "RY")] = -(a * x + c * y)  # -w,x
    return out


def patch(triangles: bool) -> Structure:
    """Five quadrilaterals, none of them a rectangle, round four inner nodes; or each cut in two."""
    nodes = {1: (0, 0), 2: (0.24, 0), 3: (0.24, 0.12), 4: (0, 0.12)}
    nodes |= {5: (0.04, 0.02), 6: (0.18, 0.03), 7: (0.16, 0.08), 8: (0.08, 0.08)}
    rims = [(1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8), (5, 6, 7, 8)]
    if triangles:
        rims = [rim for a, b, c, d in rims for rim in ((a, b, c), (a, c, d))]  # type: ignore[misc]
    members = tuple(Plate(i, rim, 0.001, STEEL) for i, rim in enumerate(rims, 1))
    return Structure(nodes, (), non_bar_members=members, directions=("Z", "RX", "RY"))


@pytest.mark.parametrize("triangles", [False, True], ids=["quadrilaterals", "triangles"])
@pytest.mark.parametrize("curvature", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.3, -0.2, 1.0)])
def test_a_patch_bends_as_its_rim_says(triangles: bool, curvature: tuple[float, float, float]) -> None:
    structure = patch(triangles)
    want = bent(structure, curvature)
    values = np.array([want[dof] for dof in structure.dofs])
    inner = np.array([dof.node > 4 for dof in structure.dofs])
    k = assemble(structure).stiffness.toarray()
    found = np.linalg.solve(k[np.ix_(inner, inner)], -k[np.ix_(inner, ~inner)] @ values[~inner])
    # rounding times the condition of a plate that shears (L/t)^2 = 6e4 times as hard as it bends
    np.testing.assert_allclose(found, values[inner], atol=1e-9 * np.abs(values).max())


@pytest.mark.parametrize("n_elements", [(3, 2), (12, 8)], ids=["dense", "sparse"])
def test_a_free_plate_moves_without_force_in_three_ways(n_elements: tuple[int, int]) -> None:
    free = plate(length=0.6, width=0.4, thickness=0.004, n_elements=n_elements, material=STEEL)
    system = assemble(free)
    assert system.rigid is not None
    force = np.abs(system.stiffness @ system.rigid)
    assert (force <= 1e-11 * (abs(system.stiffness) @ np.abs(system.rigid))).all()
    basis, n_rigid_body = lowest_modes(system, 3)
    assert n_rigid_body == 3
    assert basis.frequencies[0] > 10.0


def test_the_plate_of_the_catalogue_has_the_modes_of_a_free_rectangle() -> None:
    free = STRUCTURES["plate"]()
    basis, n_rigid_body = lowest_modes(assemble(free), 2)
    # Leissa, Journal of Sound and Vibration 31 (1973) 257-293, free on all sides, a/b = 1.5, nu = 0.3:
    # omega a^2 sqrt(rho t / D) = 20.128, 21.603
    rigidity = 2.09e11 * 0.004**3 / 12 / (1 - 0.3**2)
    known = np.array([20.128, 21.603]) / 0.6**2 * np.sqrt(rigidity / (7800 * 0.004)) / (2 * np.pi)
    # the mesh: second order with 8 elements across half a wave
    np.testing.assert_allclose(basis.frequencies, known, rtol=0.025)
    assert n_rigid_body == 3
    np.testing.assert_allclose(basis.loss_factors, 0.002, rtol=1e-9)


@pytest.mark.parametrize(
    ("property", "factor"),
    [(MemberProperty.BENDING_STIFFNESS, 1.0), (MemberProperty.MODULUS, 1.0), (MemberProperty.DENSITY, -1.0)],
)
def test_properties_of_all_elements_move_frequencies_as_their_roots(
    property: MemberProperty, factor: float
) -> None:
    free = supported(0.004, 4)
    every = tuple(member.number for member in free.all_members)
    moved = change(free, [MemberChange(every, property, factor=1.21)])
    by = 1.1**factor
    # K or M times a number: rounding, times the highest eigenvalue over the lowest, 1e8
    np.testing.assert_allclose(frequencies(moved, 3), by * frequencies(free, 3), rtol=1e-8)


def test_a_bending_stiffness_may_be_set_in_its_own_unit() -> None:
    free = supported(0.004, 4)
    rigidity = STEEL.modulus * 0.004**3 / 12 / (1 - STEEL.poisson_ratio**2)
    moved = change(free, [MemberChange((1,), MemberProperty.BENDING_STIFFNESS, value=2 * rigidity)])
    assert moved.non_bar_members[0].bending_factor == pytest.approx(2.0)


@pytest.mark.parametrize(
    "corners",
    [
        {1: (0, 0), 2: (1, 0), 3: (0, 1), 4: (1, 1)},  # crossed
        {1: (0, 0), 2: (1, 0), 3: (0.2, 0.2), 4: (0, 1)},  # hollow
        {1: (0, 0), 2: (1, 0), 3: (2, 0), 4: (3, 0)},  # flat
    ],
)
def test_corners_that_make_no_plate_are_refused(corners: dict[int, tuple[float, float]]) -> None:
    with pytest.raises(StructureError, match="plate element 7"):
        Structure(
            corners, (), non_bar_members=(Plate(7, (1, 2, 3, 4), 0.01, STEEL),), directions=("Z", "RX", "RY")
        )


def test_a_member_of_a_plate_altered_is_the_plate_assembled_with_it() -> None:
    free = plate(length=0.6, width=0.4, thickness=0.004, n_elements=(3, 2), material=STEEL)
    altered = assemble(free).change_member(2, mass=0.5, bending=-0.3).folded()
    members = tuple(
        replace(m, mass_factor=1.5, bending_factor=0.7) if m.number == 2 else m for m in free.non_bar_members
    )
    fresh = assemble(replace(free, non_bar_members=members))
    for ours, theirs in ((altered.mass, fresh.mass), (altered.stiffness, fresh.stiffness)):
        dense = theirs.toarray()
        np.testing.assert_allclose(ours.toarray(), dense, atol=1e-12 * np.abs(dense).max())
