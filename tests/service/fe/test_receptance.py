"""The modal sum with its attachments is held against the direct solution of the same matrices."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping, ViscousDamping
from modallab.fe.receptance import direct_receptance, receptance
from modallab.fe.system import DynamicSystem
from tests.rigs import steel_beam
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
