"""Assembly: new coefficients on an old pattern are a new structure's matrices."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.arrays import FloatArray
from modallab.fe.assembly import Assembly, Coefficients, assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping, ViscousDamping
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from tests.strategies import frames, structural, viscous

FACTORS = st.floats(0.2, 5.0)


def dense(system: DynamicSystem) -> list[FloatArray]:
    folded = system.folded()
    parts = (folded.mass, folded.stiffness, folded.damping, folded.viscous)
    return [np.zeros((len(system.dofs),) * 2) if p is None else p.toarray() for p in parts]


def assert_same(one: DynamicSystem, other: DynamicSystem) -> None:
    for ours, theirs in zip(dense(one), dense(other), strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-12 * np.abs(theirs).max(initial=1e-300))


def scaled(structure: Structure, mass: float, axial: float, bending: float) -> Structure:
    first = replace(structure.members[0], mass_factor=mass, axial_factor=axial, bending_factor=bending)
    return replace(structure, members=(first, *structure.members[1:]))


@settings(max_examples=25, deadline=None)
@given(structure=frames(structural | viscous), mass=FACTORS, axial=FACTORS, bending=FACTORS)
def test_new_coefficients_are_a_fresh_assembly(
    structure: Structure, mass: float, axial: float, bending: float
) -> None:
    law = structure.damping
    common = law.stiffness_coefficient if isinstance(law, StructuralDamping) else 0.0
    n = len(structure.members)
    first = np.arange(n) == 0
    coefficients = Coefficients(
        mass=np.where(first, mass, 1.0),
        axial=np.where(first, axial, 1.0),
        bending=np.where(first, bending, 1.0),
        loss_factor=np.array([common if m.loss_factor is None else m.loss_factor for m in structure.members]),
    )
    again = Assembly(structure).system(coefficients)
    assert_same(again, assemble(scaled(structure, mass, axial, bending)))


@settings(max_examples=25, deadline=None)
@given(structure=frames(structural | viscous), mass=FACTORS, axial=FACTORS, bending=FACTORS)
def test_a_changed_member_is_the_structure_assembled_with_it(
    structure: Structure, mass: float, axial: float, bending: float
) -> None:
    number = structure.members[0].number
    attached = assemble(structure).change_member(number, mass=mass - 1, axial=axial - 1, bending=bending - 1)
    assert_same(attached, assemble(scaled(structure, mass, axial, bending)))


@pytest.mark.parametrize("damping", [StructuralDamping(0.01, 5.0), ViscousDamping(1e-5, 2.0)])
def test_damping_follows_its_law(damping: StructuralDamping | ViscousDamping) -> None:
    system = assemble(replace(STRUCTURES["bay"](), damping=damping))
    mass, stiffness, structural_part, viscous_part = dense(system)
    expected = damping.mass_coefficient * mass + damping.stiffness_coefficient * stiffness
    found = structural_part if isinstance(damping, StructuralDamping) else viscous_part
    np.testing.assert_allclose(found, expected, atol=1e-12 * expected.max())


def test_a_frame_weighs_what_its_bars_weigh() -> None:
    structure = STRUCTURES["bay"]()
    system = assemble(structure)
    along = np.array([dof.direction == "X" for dof in system.dofs], float)
    weight = sum(m.material.density * m.section.area * structure.length(m) for m in structure.members)
    assert along @ system.mass @ along == pytest.approx(weight, rel=1e-12)


def test_turning_a_frame_leaves_its_frequencies() -> None:
    structure = STRUCTURES["bay"]()
    c, s = np.cos(0.7), np.sin(0.7)
    turned = replace(
        structure, nodes={n: (c * x - s * y, s * x + c * y) for n, (x, y) in structure.nodes.items()}
    )
    np.testing.assert_allclose(
        assemble(turned).modes().elastic(10).frequencies,
        assemble(structure).modes().elastic(10).frequencies,
        rtol=1e-7,  # rounding, times the ratio of the largest eigenvalue to the first
    )
