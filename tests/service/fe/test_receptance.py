"""The modal sum with its attachments is held against the direct solution of the same matrices."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.attachment import merged
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping, ViscousDamping
from modallab.fe.receptance import (
    attached,
    attached_variants,
    condense_if_cheaper,
    direct_receptance,
    receptance,
    solve_small,
)
from modallab.fe.system import DynamicSystem
from tests.rigs import beam_system, steel_beam
from tests.strategies import loaded_systems

FREQ = np.array([3.0, 17.0, 61.0, 240.0, 800.0])


def everywhere(system: DynamicSystem) -> np.ndarray:
    return np.eye(len(system.dofs))


@settings(max_examples=60, deadline=None)
@given(system=loaded_systems())
def test_the_modal_sum_is_the_direct_solution(system: DynamicSystem) -> None:
    pick = everywhere(system)
    exact = direct_receptance(system, FREQ, pick, pick)
    # all modes are summed, so only rounding is left: the eigen-solution loses digits as the ratio of
    # the highest eigenvalue to the lowest, up to 1e6 or so for these frames
    scale = np.abs(exact).max(axis=(1, 2), keepdims=True)
    assert (np.abs(receptance(system, FREQ, pick, pick) - exact) < 1e-6 * scale).all()


def test_masses_that_couple_rigid_body_modes_by_damping_leave_the_modal_sum_the_direct_solution() -> None:
    # Loss in proportion to mass, but not of what is hung on: three modes at 0 Hz of nearly one loss, in a
    # structure whose highest eigenvalue is 1e6 times its lowest elastic one.
    system = assemble(replace(STRUCTURES["garteur"](), damping=StructuralDamping(0.005, 100.0)))
    nodes = tuple(sorted({dof.node for dof in system.dofs}))[1::4]
    system = system.add_masses(nodes, 0.04).folded()
    pick = system.selection(tuple(Dof(node, "Y") for node in nodes))
    exact = direct_receptance(system, FREQ, pick, pick[:, :1])
    scale = np.abs(exact).max(axis=(1, 2), keepdims=True)
    # rounding of that ratio
    assert (np.abs(receptance(system, FREQ, pick, pick[:, :1]) - exact) < 1e-6 * scale).all()


@settings(max_examples=40, deadline=None)
@given(system=loaded_systems())
def test_receptance_is_reciprocal_and_passive(system: DynamicSystem) -> None:
    pick = everywhere(system)
    alpha = receptance(system, FREQ, pick, pick)
    scale = np.abs(alpha).max()
    np.testing.assert_allclose(alpha, alpha.swapaxes(1, 2), atol=1e-9 * scale)
    # power taken from any force: -Im alpha is positive semidefinite, but for rounding
    lost = np.linalg.eigvalsh(-(alpha.imag + alpha.imag.swapaxes(1, 2)) / 2)
    assert (lost > -1e-7 * scale).all()


@settings(max_examples=20, deadline=None)
@given(n_masses=st.integers(1, 3), signs=st.lists(st.sampled_from((1, -1)), min_size=2, max_size=2))
def test_a_sensor_that_looks_the_other_way_turns_the_sign(n_masses: int, signs: list[int]) -> None:
    system = assemble(STRUCTURES["chapter-5-beam"]())
    for node in range(1, n_masses + 1):
        system = system.add_mass(node, 0.02)
    plain = system.selection((Dof(1, "Y"), Dof(9, "Y")))
    turned = system.selection((Dof(1, "Y", signs[0]), Dof(9, "Y", signs[1])))
    expected = receptance(system, FREQ, plain, plain) * np.outer(signs, signs)
    np.testing.assert_array_equal(receptance(system, FREQ, turned, turned), expected)


@pytest.mark.parametrize("name", ["chapter-5-beam", "cantilever"])
def test_a_beam_far_below_its_modes_is_a_body_or_a_spring(name: str) -> None:
    system = assemble(replace(STRUCTURES[name](), damping=StructuralDamping()))
    at = system.selection((Dof(21, "Y"),))
    freq = np.array([0.05])
    alpha = receptance(system, freq, at, at)[0, 0, 0]
    if name == "cantilever":
        expected = 1.5**3 / (3 * 2.09e11 * 4.1667e-9)  # L^3 / 3 E I
    else:
        mass = 7800.0 * 5e-4 * 1.5
        # at the end of a free uniform bar: 1/m for its centre, (L/2)^2/J = 3/m for its turning
        expected = -(4 / mass) / (2 * np.pi * freq[0]) ** 2
    # the first mode adds (0.05 / 3.7)^2 to the spring, and less to the body
    assert abs(alpha / expected - 1) < 1e-2


@pytest.mark.parametrize("unlike", [False, True], ids=["of one width", "of several widths"])
def test_variants_together_are_the_variants_one_by_one(unlike: bool) -> None:
    system = assemble(STRUCTURES["chapter-5-beam"]()).add_mass(1, 0.01).change_member(7, bending=0.3)
    variants = [system.add_mass(node, 0.02) for node in (1, 9, 21)]
    if unlike:
        variants[1] = variants[1].change_member(3, mass=0.1)
    lefts = [system.selection((Dof(node, "Y"),)) for node in (1, 9, 21)]
    right = system.selection((Dof(1, "Y"),))
    response = system.base_modes(800.0).at(2 * np.pi * FREQ)
    together = attached_variants(variants, 2 * np.pi * FREQ, lefts, [right] * len(variants))
    apart = [attached(response, v, left, right) for v, left in zip(variants, lefts, strict=True)]
    np.testing.assert_allclose(together, apart, rtol=1e-9)  # the same equations in another order


def many_masses() -> DynamicSystem:
    system = assemble(replace(STRUCTURES["chapter-5-beam"](), damping=StructuralDamping(0.005, 100.0)))
    return system.add_masses([*range(2, 20), 2, 3], 0.02)  # some nodes carry two


def test_many_attachments_are_folded_once_and_for_all_that_follow() -> None:
    system = many_masses()
    few_more = system.change_member(7, bending=0.3).add_mass(5, 0.1)
    at = system.selection((Dof(1, "Y"), Dof(9, "Y")))
    assert condense_if_cheaper(system).attachments == ()
    assert condense_if_cheaper(few_more).mass is condense_if_cheaper(system).mass
    for loaded in (system, few_more):
        folded = attached_variants([loaded], 2 * np.pi * FREQ, [at], [at])[0]
        # modes of other matrices against the Woodbury identity: rounding, magnified at antiresonances
        np.testing.assert_allclose(folded, direct_receptance(loaded, FREQ, at, at), rtol=1e-6)


def test_a_damper_stays_attached_where_masses_are_folded() -> None:
    system = many_masses().add_damper(Dof(7, "Y"), 40.0)
    at = system.selection((Dof(1, "Y"), Dof(9, "Y")))
    folded = condense_if_cheaper(system)
    assert folded.viscous is None  # which would couple the modes at every frequency
    assert [a.viscous is not None for a in folded.attachments] == [True]
    found = attached_variants([system], 2 * np.pi * FREQ, [at], [at])[0]
    np.testing.assert_allclose(found, direct_receptance(system, FREQ, at, at), rtol=1e-6)  # as above


def test_what_hangs_twice_does_not_stand_in_for_what_was_folded_before() -> None:
    system = many_masses()
    at = system.selection((Dof(1, "Y"), Dof(9, "Y")))
    condense_if_cheaper(system.change_member(7, bending=0.3))
    other = system.change_member(7, bending=0.6).add_mass(5, 0.02)  # as many, one as another that it has
    folded = attached_variants([other], 2 * np.pi * FREQ, [at], [at])[0]
    np.testing.assert_allclose(folded, direct_receptance(other, FREQ, at, at), rtol=1e-6)  # as above


@pytest.mark.parametrize("first", [0, 1], ids=["it comes first", "it comes last"])
def test_a_variant_may_carry_again_what_all_carry(first: int) -> None:
    system = assemble(STRUCTURES["chapter-5-beam"]()).add_mass(1, 0.02)
    both = (system.add_mass(1, 0.02).add_mass(5, 0.01), system.add_mass(5, 0.03))
    variants = [both[first], both[1 - first]]
    at = system.selection((Dof(1, "Y"), Dof(9, "Y")))
    found = attached_variants(variants, 2 * np.pi * FREQ, [at, at], [at, at])
    wanted = [direct_receptance(variant, FREQ, at, at) for variant in variants]
    np.testing.assert_allclose(found, wanted, rtol=1e-6)  # as above


def test_masses_in_one_place_are_one_mass() -> None:
    system = assemble(STRUCTURES["chapter-5-beam"]())
    nodes, omega = (5, 9), 2 * np.pi * FREQ
    twice = [system.add_mass(node, 0.02).add_mass(node, 0.01) for node in nodes]
    at = [system.selection((Dof(node, "Y"), Dof(1, "Y"))) for node in nodes]
    found = attached_variants(twice, omega, at, at)
    once = attached_variants([system.add_mass(node, 0.03) for node in nodes], omega, at, at)
    np.testing.assert_allclose(found, once, rtol=1e-12)  # the same equations
    wanted = [direct_receptance(variant, FREQ, a, a) for variant, a in zip(twice, at, strict=True)]
    np.testing.assert_allclose(found, wanted, rtol=1e-6)  # as above


@pytest.mark.parametrize("coupled", [False, True], ids=["masses alone", "what couples motions too"])
def test_many_attachments_at_few_frequencies_are_not_folded_and_give_the_direct_solution(
    coupled: bool,
) -> None:
    system = many_masses()
    if coupled:
        system = system.change_member(7, bending=0.3).add_oscillator(Dof(5, "Y"), 0.05, 90.0, 0.02)
    at = system.selection((Dof(1, "Y"), Dof(9, "Y"), Dof(2, "Y")))
    assert condense_if_cheaper(system, len(FREQ)) is system
    found = attached_variants([system, system], 2 * np.pi * FREQ, [at, at[:, ::-1]], [at[:, :1]] * 2)
    beyond = np.zeros((sum(a.inner for a in system.attachments), 3))
    everything = np.vstack([at, beyond])
    wanted = direct_receptance(system, FREQ, everything, everything[:, :1])
    # rounding of the eigen-solution, magnified at antiresonances
    np.testing.assert_allclose(found, [wanted, wanted[:, ::-1]], rtol=1e-6)


def test_a_few_sets_of_attachments_stay_folded_beside_one_another() -> None:
    system, other = many_masses(), many_masses()
    other = replace(other, attachments=system.attachments[:11], cache=system.cache)
    first = condense_if_cheaper(system).mass
    assert condense_if_cheaper(other).mass is not first
    assert condense_if_cheaper(system).mass is first


@pytest.mark.parametrize("law", [StructuralDamping(0.005, 100.0), ViscousDamping(1e-6, 3.0)])
def test_a_member_that_is_all_but_taken_out_of_a_large_structure_leaves_the_exact_receptance(
    law: StructuralDamping | ViscousDamping,
) -> None:
    system = assemble(steel_beam(law, n_elements=150))
    points = np.eye(len(system.dofs))[:, [0, 8, -2]]
    freq = np.linspace(3.0, 800.0, 40)
    for softened in (system.add_joint(70, 1e-3), system.change_member(49, bending=-0.95)):
        found = receptance(softened, freq, points, points)
        beyond = np.zeros((sum(a.inner for a in softened.attachments), 3))
        all_points = np.vstack([points, beyond])
        wanted = direct_receptance(softened, freq, all_points, all_points)
        # the series for high modes leaves out (1/4)^4 of what they add at the top of the band
        np.testing.assert_allclose(found, wanted, rtol=4e-3, atol=1e-5 * np.abs(wanted).max())


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_small_systems_are_solved_as_by_the_solver(n: int) -> None:
    rng = np.random.default_rng(n)
    matrix = rng.standard_normal((2, 5, n, n)) + 1j * rng.standard_normal((2, 5, n, n))
    matrix += 2 * n * np.eye(n)  # well-conditioned, as a structure with what is attached to it
    loads = rng.standard_normal((2, 5, n, 3)) + 1j * rng.standard_normal((2, 5, n, 3))
    expected = np.linalg.solve(matrix, loads)
    assert solve_small(matrix, loads) == pytest.approx(expected, rel=1e-12, abs=1e-14)  # rounding


def test_attachments_with_motions_of_their_own_are_not_merged() -> None:
    oscillators = beam_system().add_oscillator(Dof(5, "Y"), 0.02, 90.0, 0.05).attachments
    assert merged(oscillators) == oscillators
    masses = beam_system().add_mass(3, 0.1).add_mass(4, 0.1).attachments
    mass, oscillator = merged((*masses, *oscillators))
    assert mass.is_constant
    assert oscillator is oscillators[0]
