"""Modes: rigid bodies counted, mass-normalised, the same by dense and sparse solution."""

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import Damping, ModalDamping, StructuralDamping, ViscousDamping
from modallab.fe.modes import modal_basis
from modallab.fe.receptance import direct_receptance, receptance
from modallab.fe.settings import CACHE, EIGENSOLUTION
from modallab.fe.structure import GroundSpringElement, Material, Member, Section, Structure, Support
from tests.strategies import frames

HOLDS: dict[str, tuple[tuple[Support, ...], int]] = {
    "free": ((), 3),
    "on a roller": ((Support(1, ("Y",)),), 2),
    "on a pin": ((Support(1, ("X", "Y")),), 1),
    "on a pin and a roller": ((Support(1, ("X", "Y")), Support(8, ("Y",))), 0),
    "on two rollers of one line": ((Support(1, ("Y",)), Support(8, ("Y",))), 1),
    "clamped": ((Support(1, ("X", "Y", "RZ")),), 0),
}


@pytest.mark.parametrize("hold", HOLDS)
def test_rigid_body_modes_are_counted_and_cost_no_elastic_one(hold: str) -> None:
    supports, expected = HOLDS[hold]
    basis = assemble(replace(STRUCTURES["bay"](), supports=supports)).modes()
    assert basis.n_rigid_body == expected
    assert (basis.frequencies[:expected] == 0).all()
    assert basis.frequencies[expected] > 1.0


def test_a_spring_to_ground_takes_a_rigid_body_mode_away() -> None:
    springs = (GroundSpringElement(Dof(1, "Y"), 1e3), GroundSpringElement(Dof(21, "Y"), 1e3))
    basis = assemble(replace(STRUCTURES["chapter-5-beam"](), springs=springs)).modes()
    assert basis.n_rigid_body == 0
    # on springs far softer than itself it bounces and rocks as a rigid bar: 2k/m and 6k/m, but for
    # what the bar bends: the springs' stiffness over the bar's, 3 in 1000
    mass = 7800.0 * 5e-4 * 1.5
    rigid = np.sqrt(np.array([2e3, 6e3]) / mass) / (2 * np.pi)
    np.testing.assert_allclose(basis.frequencies[:2], rigid, rtol=5e-2)


@settings(max_examples=30, deadline=None)
@given(structure=frames())
def test_shapes_are_mass_normalised_by_plain_transpose(structure: Structure) -> None:
    system = assemble(structure)
    basis = system.modes()
    product = basis.shapes.T @ system.mass @ basis.shapes
    np.testing.assert_allclose(product, np.eye(len(product)), atol=1e-8)  # rounding of the eigen-solution


def test_elastic_modes_of_a_slender_frame_have_no_rigid_body_motion() -> None:
    section, material = Section(6.62e-3, 1e-9), Material(7e10, 2700.0)
    nodes = {1: (0.0, -0.8), 2: (0.7, -0.8), 3: (1.4, 1.0), 4: (2.1, -0.8)}
    members = tuple(Member(n, (n, n + 1), section, material) for n in range(1, 4))
    system = assemble(Structure(nodes, members))
    basis = system.modes()
    bodies, elastic = np.split(basis.shapes.real, [3], axis=1)
    # axial modes are 1e5 times stiffer than the lowest bending mode: a dense solution alone leaves 3e-9
    np.testing.assert_allclose(bodies.T @ (system.mass @ elastic), 0.0, atol=1e-11)


@pytest.mark.parametrize(("stiffness", "mass"), [(0.005, 100.0), (0.01, 0.0), (0.0, 40.0)])
def test_structural_damping_gives_each_mode_its_loss_factor(stiffness: float, mass: float) -> None:
    law = StructuralDamping(stiffness, mass)
    basis = assemble(replace(STRUCTURES["chapter-5-beam"](), damping=law)).modes()
    squares = basis.elastic().eigenvalues.real
    np.testing.assert_allclose(basis.elastic().loss_factors, mass / squares + stiffness, rtol=1e-6)
    # a rigid-body mode has no stiffness to lose, but the mass-proportional part acts on it
    np.testing.assert_allclose(basis.eigenvalues[: basis.n_rigid_body].imag, mass, atol=1e-6)


def test_viscous_damping_gives_twice_the_damping_ratio() -> None:
    law = ViscousDamping(stiffness_coefficient=1e-6, mass_coefficient=3.0)
    basis = assemble(replace(STRUCTURES["chapter-5-beam"](), damping=law)).modes().elastic(8)
    omega = 2 * np.pi * basis.frequencies
    np.testing.assert_allclose(basis.loss_factors, 3.0 / omega + 1e-6 * omega, rtol=1e-6)


@pytest.mark.parametrize("law", [ViscousDamping(1e-6, 3.0), StructuralDamping(0.01, 0.0)])
def test_a_mode_decays_by_half_of_its_loss_factor_a_radian(law: Damping) -> None:
    basis = assemble(replace(STRUCTURES["chapter-5-beam"](), damping=law)).modes().elastic(8)
    expected = np.pi * basis.frequencies * basis.loss_factors
    np.testing.assert_allclose(basis.decay_rates(0.0), expected, rtol=1e-9)  # rounding
    # a rigid-body mode decays by viscous damping alone
    least = 3 * np.pi * basis.frequencies[-1]
    viscous = 0.0 if basis.viscous is None else np.diag(basis.viscous).real / 2
    np.testing.assert_allclose(basis.decay_rates(least), viscous, rtol=1e-9)


def test_modal_damping_gives_the_loss_factors_asked_for() -> None:
    law = ModalDamping((0.01, 0.02, 0.03))
    basis = assemble(replace(STRUCTURES["chapter-5-beam"](), damping=law)).modes().elastic(6)
    np.testing.assert_allclose(basis.loss_factors, [0.01, 0.02, 0.03, 0.03, 0.03, 0.03], rtol=1e-6)


LAWS: tuple[Damping, ...] = (StructuralDamping(0.01, 50.0), ViscousDamping(1e-6, 2.0))


def long_beam(supports: tuple[Support, ...], damping: Damping) -> Structure:
    return beam(
        length=1.5,
        n_elements=EIGENSOLUTION.dense_dofs // 2 + 10,
        section=Section(5e-4, 4.1667e-9),
        material=Material(2.09e11, 7800.0),
        damping=damping,
        supports=supports,
    )


@pytest.mark.parametrize("supports", [(), (Support(1, ("Y", "RZ")),)], ids=["free", "clamped"])
def test_the_sparse_solution_is_the_dense_one(supports: tuple[Support, ...]) -> None:
    system = assemble(long_beam(supports, LAWS[0]))
    assert len(system.dofs) >= EIGENSOLUTION.dense_dofs
    sparse = system.modes(800.0)
    matrices = (system.mass, system.stiffness, system.damping, None, system.rigid)
    dense = modal_basis(*matrices)
    assert sparse.n_rigid_body == dense.n_rigid_body == (0 if supports else 2)
    n = len(sparse.eigenvalues)
    assert dense.frequencies[n] > 1600.0  # twice what was asked for is there, to the last
    # the dense solution is the worse one: eigenvalues lose the ratio of the largest to them, 1e10
    np.testing.assert_allclose(sparse.frequencies, dense.frequencies[:n], rtol=1e-4, atol=1e-9)


@pytest.mark.parametrize("damping", LAWS, ids=["structural", "viscous"])
def test_modes_left_out_above_still_count(damping: Damping) -> None:
    system = assemble(long_beam((), damping)).add_mass(5, 0.05)
    freq = np.array([5.0, 33.0, 155.0, 390.0, 800.0])
    pick = system.selection((Dof(1, "Y"), Dof(40, "Y")))
    exact = direct_receptance(system, freq, pick, pick)
    # their series ends at (800/1600)^8, and their damping, 1 % of what they add, is left out
    np.testing.assert_allclose(receptance(system, freq, pick, pick), exact, rtol=1e-2)


def test_a_basis_solved_for_low_frequencies_is_not_used_for_high_ones() -> None:
    system = assemble(long_beam((), StructuralDamping()))
    low, high = system.base_modes(100.0), system.base_modes(150.0)
    assert low.frequencies.max() <= 200.0 < high.frequencies.max() <= 300.0
    assert system.base_modes(120.0) is high


def test_modes_asked_for_by_none_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="at least one mode"):
        assemble(STRUCTURES["bay"]()).modes().elastic(0)


def test_the_responses_of_many_bases_are_not_all_kept() -> None:
    # a drifting test solves one system a run and value: all their responses took 8 GB
    system, omega = assemble(STRUCTURES["chapter-5-beam"]()), np.linspace(10.0, 1000.0, 20)
    variants = [system.scaled(stiffness=1 + i / 1000) for i in range(CACHE.bases_with_responses + 2)]
    first = weakref.ref(variants[0].base_modes(200.0).at(omega))
    last = variants[1].base_modes(200.0).at(omega)
    assert variants[1].base_modes(200.0).at(omega) is last
    for variant in variants[2:]:
        variant.base_modes(200.0).at(omega)
    gc.collect()
    assert first() is None
