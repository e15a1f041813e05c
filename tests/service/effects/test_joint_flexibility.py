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
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.structure import Support
from modallab.fe.system import DynamicSystem
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


def test_the_mass_matrix_may_stay_that_of_the_member_without_a_crack() -> None:
    flexibility = LENGTH / BEND

    def system(share: float) -> DynamicSystem:
        return JointFlexibility(Dof(6, "RZ"), flexibility, share).on_system(SYSTEM, SHOT).folded()

    bare, cracked_system = SYSTEM.mass.toarray(), system(0.0)
    np.testing.assert_allclose(cracked_system.mass.toarray(), bare, atol=1e-12 * np.abs(bare).max())
    # Static loads know no mass: both models of the crack bend alike.
    whole = system(1.0)
    load = np.zeros(whole.stiffness.shape[0])
    load[SYSTEM.index(Dof(15, "Y"))] = 1.0
    n = len(SYSTEM.dofs)
    bent = np.linalg.lstsq(whole.stiffness.toarray(), load, rcond=None)[0][:n]
    np.testing.assert_allclose(
        np.linalg.lstsq(cracked_system.stiffness.toarray(), load[:n], rcond=None)[0],
        bent,
        atol=1e-6 * abs(bent).max(),
    )


def test_both_mass_matrices_are_those_of_a_crack_in_a_fine_mesh() -> None:
    flexibility = 0.3 * LENGTH / BEND
    unchanged = JointFlexibility(Dof(16, "RZ"), flexibility, 0.0).on_system(SYSTEM, SHOT)
    frequencies = unchanged.modes().elastic(3).frequencies
    # the kink within the cracked element, a thirtieth of the beam, moves some of its mass
    np.testing.assert_allclose(frequencies, exactly(LENGTH / 2, flexibility), rtol=2e-2)


def test_a_diagnosis_tries_either_member_with_its_mass_matrix_unchanged_as_well() -> None:
    at = Dof(6, "RZ")
    crack = JointFlexibility(at, 1e-4)
    other, second = crack.variants(beam_system())
    assert other == JointFlexibility(at, 1e-4, consistent_mass=0.0)
    assert second == JointFlexibility(at, 1e-4, consistent_mass=0.0, member=6)
    assert crack in other.variants(beam_system())
    assert [name for name, *_ in other.fitted_specs()] == ["flexibility"]
    assert other.added_to(PINNED).effects == (other.spec,)  # a spring of the model has the kinked shape
    assert len(crack.added_to(PINNED).joints) == 1


def test_of_three_members_each_may_be_loose_with_either_mass_matrix() -> None:
    system = assemble(STRUCTURES["bay"]())
    assert system.members is not None
    node = next(n for n in system.members.joints if len(system.members.bars_at(n)) == 3)
    joint = JointFlexibility(Dof(node, "RZ"))
    choices = {(effect.member, effect.consistent_mass) for effect in (joint, *joint.variants(system))}
    _, second, third = system.members.bars_at(node)
    assert choices == {(number, mass) for number in (0, second, third) for mass in (0.0, 1.0)}


def test_a_member_elsewhere_is_none_of_the_joint() -> None:
    with pytest.raises(InvalidInputError, match="member 3") as caught:
        JointFlexibility(Dof(6, "RZ"), member=3).check(steel_beam())
    assert caught.value.context["allowed"] == [0, 5, 6]


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
