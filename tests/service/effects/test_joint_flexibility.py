"""Cracks: the exact transfer matrix of a cracked beam, and Rayleigh's first-order drop of frequency."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.effects.joint_flexibility import JointFlexibility
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.structure import Support
from modallab.rig.setup import AcquisitionRun
from tests.rigs import BAR, STEEL, beam_system, dofs, rig, steel_beam

N, LENGTH = 30, 1.2
BEND = STEEL.modulus * BAR.second_moment
PINNED = beam(
    length=LENGTH,
    n_elements=N,
    section=BAR,
    material=STEEL,
    supports=(Support(1, ("Y",)), Support(N + 1, ("Y",))),
)
SYSTEM = assemble(PINNED)
SHOT = AcquisitionRun(dofs(5), dofs(5))


def cracked(node: int, flexibility: float) -> FloatArray:
    effect = JointFlexibility(Dof(node, "RZ"), flexibility)
    return effect.on_system(SYSTEM, SHOT).modes().elastic(3).frequencies


def exactly(x: float, flexibility: float) -> FloatArray:
    """Hz, three frequencies of the pinned beam whose slope jumps by flexibility times moment at x, m.

    By the transfer matrix of (w, w', M, V) of a beam without elements.
    """

    def unbalanced(frequency: float) -> float:
        square = STEEL.density * BAR.area * (2 * np.pi * frequency) ** 2
        along = np.array([[0, 1, 0, 0], [0, 0, 1 / BEND, 0], [0, 0, 0, 1], [square, 0, 0, 0]])
        jump = np.eye(4)
        jump[1, 2] = flexibility
        whole = expm(along * (LENGTH - x)) @ jump @ expm(along * x)
        return float(np.linalg.det(whole[np.ix_([0, 2], [1, 3])]))

    grid = np.linspace(0.1, 400.0, 800)
    values = [unbalanced(f) for f in grid]
    steps = [i for i in range(len(grid) - 1) if values[i] * values[i + 1] < 0][:3]
    return np.array([brentq(unbalanced, grid[i], grid[i + 1], xtol=1e-10) for i in steps])


@pytest.mark.parametrize("stiffness_ratio", [0.01, 0.3, 10.0, 1000.0])  # flexibility E I / L
@pytest.mark.parametrize("node", [6, 16])
def test_a_cracked_beam_has_the_frequencies_of_the_exact_transfer_matrix(
    node: int, stiffness_ratio: float
) -> None:
    flexibility = stiffness_ratio * LENGTH / BEND
    wanted = exactly(LENGTH * (node - 1) / N, flexibility)
    # cubic elements: (beta h)^4 / 1440 = 7e-6 of the third mode
    np.testing.assert_allclose(cracked(node, flexibility), wanted, rtol=1e-5)


def test_a_small_crack_lowers_frequencies_by_rayleighs_quotient() -> None:
    """Sine modes: d omega^2 / omega^2 = -flexibility M^2 / 2U = -2 (E I / L) flexibility sin^2(k x)."""
    flexibility, x = 1e-4 * LENGTH / BEND, LENGTH * 9 / N
    bare = SYSTEM.modes().elastic(3).frequencies
    found = (cracked(10, flexibility) / bare) ** 2 - 1
    k = np.arange(1, 4) * np.pi / LENGTH
    wanted = -2 * BEND / LENGTH * flexibility * np.sin(k * x) ** 2
    # the second order is of the size of the first, 2e-4, times the number of modes that take part; the
    # moment of a cubic element errs by (k h)^2 / 12 = 8e-3 at the third mode
    np.testing.assert_allclose(found, wanted, rtol=1e-2)


def test_a_mode_without_a_bending_moment_there_stays() -> None:
    bare = SYSTEM.modes().elastic(3).frequencies
    np.testing.assert_allclose(cracked(16, 1e-2)[1], bare[1], rtol=1e-8)  # mid-span, second mode: rounding


def test_a_very_loose_joint_is_a_hinge() -> None:
    # two pinned halves: in the first mode they turn about their pins like rigid bars, at no frequency
    assert cracked(16, 1e6)[0] < 0.01


@pytest.mark.parametrize("at", [Dof(1, "RZ"), Dof(21, "RZ"), Dof(5, "Y")])
def test_it_needs_members_on_both_sides_and_a_rotation(at: Dof) -> None:
    with pytest.raises(InvalidInputError) as caught:
        JointFlexibility(at).check(steel_beam())
    assert caught.value.context["allowed"] == "RZ of a node where two members meet"


def test_first_looks_are_about_the_members_own_flexibility() -> None:
    looks = JointFlexibility(Dof(5, "RZ")).scan_values(beam_system(), rig(1))["flexibility"]
    own = 1.5 / 20 / (4 * BEND)  # L / 4 E I: one end turned, the other held
    assert min(looks) < own / 10
    assert max(looks) > 100 * own
