"""Altered members: joints against a model with a doubled node, and alterations that act on one another."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.core.errors import InvalidInputError
from modallab.fe.alteration import Alteration
from modallab.fe.assembly import Assembly, assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping, ViscousDamping
from modallab.fe.member_matrices import bar_of
from modallab.fe.receptance import receptance
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem

LAWS: list[StructuralDamping | ViscousDamping] = [StructuralDamping(0.01, 50.0), ViscousDamping(1e-6, 3.0)]
FREQ = np.linspace(2.0, 800.0, 60)
BEAM = STRUCTURES["chapter-5-beam"]()


def response(system: DynamicSystem) -> ComplexArray:
    points = np.eye(len(system.dofs))[:, [0, 9, 20, 39]]
    return receptance(system, FREQ, points, points)


def near(found: ComplexArray, wanted: ComplexArray, rtol: float = 1e-7) -> None:
    """Equal up to rounding: 1e-16 times the ratio of the beam's eigenvalues, 1e6."""
    np.testing.assert_allclose(found, wanted, rtol=rtol, atol=1e-2 * rtol * np.abs(wanted).max())


def doubled(structure: Structure, member: int, end: int, flexibility: float) -> ComplexArray:
    """The receptance with a rotation of its own for one end of a member, assembled by hand."""
    parts = Assembly(structure)
    n, law = len(structure.dofs), structure.damping
    mass, stiffness = np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
    for e, one in enumerate(structure.members):
        rows = parts.rows[e].copy()
        if one.number == member:
            rows[3 * end + 2] = n
        kept = rows >= 0
        where = np.ix_(rows[kept], rows[kept])
        mass[where] += parts.mass[e][np.ix_(kept, kept)]
        stiffness[where] += (parts.axial[e] + one.bending_factor * parts.bending[e])[np.ix_(kept, kept)]
        if one.number == member:
            pair = np.ix_([parts.rows[e][3 * end + 2], n], [parts.rows[e][3 * end + 2], n])
            stiffness[pair] += np.array([[1, -1], [-1, 1]]) / flexibility
    lost = law.mass_coefficient * mass + law.stiffness_coefficient * stiffness  # type: ignore[union-attr]
    points = np.eye(n + 1)[:, [0, 9, 20, 39]]
    answer = []
    for omega in 2 * np.pi * FREQ:
        turned = 1j * lost * (omega if isinstance(law, ViscousDamping) else 1.0)
        answer.append(
            points.T @ np.linalg.solve(stiffness - omega**2 * mass + turned, points.astype(complex))
        )
    return np.array(answer)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("flexibility", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize(("name", "node"), [("chapter-5-beam", 7), ("cantilever", 2), ("bay", 8)])
def test_a_joint_is_a_node_with_two_rotations_and_a_spring_between(
    law: StructuralDamping | ViscousDamping, flexibility: float, name: str, node: int
) -> None:
    structure = replace(STRUCTURES[name](), damping=law)
    if name == "bay":
        flexibility *= 1e-6  # its members are a million times stiffer
    system = assemble(structure)
    assert system.members is not None
    first, *others = system.members.bars_at(node)
    _, end = system.members.end_at(node)
    near(response(system.add_joint(node, flexibility)), doubled(structure, first, end, flexibility))
    for member in others:
        found = response(system.add_joint(node, flexibility, member=member))
        _, end = system.members.end_at(node, member)
        near(found, doubled(structure, member, end, flexibility))


def test_a_joint_grows_from_nothing_without_a_step() -> None:
    system = assemble(replace(BEAM, damping=LAWS[0]))
    whole = response(system)
    np.testing.assert_array_equal(response(system.add_joint(7, 0.0)), whole)
    assert system.members is not None
    own = system.members.bending[5][5, 5]
    # below 1e-5 / own the spring follows the elastic moment alone: an element's inertia turns it by
    # (beta h)^2 / 12 less, at most 1 %
    below, above = (response(system.add_joint(7, 1e-5 / own * f)) - whole for f in (1 - 1e-6, 1 + 1e-6))
    np.testing.assert_allclose(below, above, rtol=0, atol=0.01 * np.abs(above).max())


@pytest.mark.parametrize("flexibility", [1e-9, 1e-5, 1e-1])
def test_modes_with_a_joint_are_the_poles_of_its_receptance(flexibility: float) -> None:
    joint = assemble(replace(BEAM, damping=StructuralDamping())).add_joint(7, flexibility)
    found = joint.modes().elastic(8).frequencies
    freq = np.linspace(0.9998, 1.0002, 41)[:, None] * found
    peak = np.abs(receptance(joint, freq.ravel(), *(np.eye(42)[:, :1],) * 2)).reshape(41, 8).argmax(axis=0)
    assert ((peak > 0) & (peak < 40)).all()  # undamped poles to 2e-4, half of 5 % of the closest two


def altered(system: DynamicSystem, made: tuple[int, ...]) -> DynamicSystem:
    steps = [
        lambda s: s.alter(6, Alteration(mass=1.3)),
        lambda s: s.alter(6, Alteration(bending=0.1)),
        lambda s: s.add_joint(7, 1e-3),
        lambda s: s.add_joint(7, 2e-3),
        lambda s: s.alter(6, Alteration(shear=0.5)),
        lambda s: s.sheared(1.0),
        lambda s: s.scaled(stiffness=1.2),
    ]
    for step in made:
        system = steps[step](system)
    return system


def test_alterations_of_one_member_act_on_one_another_in_any_order() -> None:
    system = assemble(BEAM)
    orders = list(permutations(range(7)))[:: 5040 // 12]
    wanted = response(altered(system, orders[0]))
    for order in orders[1:]:
        near(response(altered(system, order)), wanted)
    assert len(altered(system, orders[0]).attachments) == 1


def test_two_joints_at_a_node_are_springs_in_series() -> None:
    system = assemble(BEAM)
    near(response(system.add_joint(7, 1e-3).add_joint(7, 2e-3)), response(system.add_joint(7, 3e-3)))


def test_a_softened_member_with_a_joint_is_the_joint_in_a_model_with_that_member() -> None:
    soft = replace(
        BEAM, members=(*BEAM.members[:5], replace(BEAM.members[5], bending_factor=0.05), *BEAM.members[6:])
    )
    near(
        response(assemble(BEAM).add_joint(7, 1e-2).change_member(6, bending=-0.95)),
        doubled(soft, 6, 1, 1e-2),
    )


def sheared_by_hand(amount: float, numbers: tuple[int, ...]) -> Structure:
    """Some members with this share of shear; the rotary inertia of 1 is right, that of others is not."""
    members = tuple(
        replace(m, element="timoshenko", section=replace(m.section, shear_coefficient=5 / 6 / amount))
        if m.number in numbers
        else m
        for m in BEAM.members
    )
    return replace(BEAM, members=members)


def test_members_that_shear_in_full_are_timoshenkos() -> None:
    every = tuple(m.number for m in BEAM.members)
    near(response(assemble(BEAM).sheared(1.0)), response(assemble(sheared_by_hand(1.0, every))))
    near(
        response(assemble(BEAM).alter(6, Alteration(shear=1.0))),
        response(assemble(sheared_by_hand(1.0, (6,)))),
    )


def test_the_mass_matrix_may_keep_the_shapes_of_bernoulli_and_euler() -> None:
    """The change of mass is then that of turning sections alone, in proportion to the amount."""
    system = assemble(BEAM)
    once, twice = (system.sheared(amount, 0.0) for amount in (1.0, 2.0))
    change = once.mass.toarray() - system.mass.toarray()
    np.testing.assert_array_equal(once.stiffness.toarray(), system.sheared(1.0).stiffness.toarray())
    np.testing.assert_allclose(
        twice.mass.toarray() - system.mass.toarray(), 2 * change, rtol=0, atol=1e-12 * np.abs(change).max()
    )
    points = np.array([BEAM.nodes[dof.node] for dof in system.dofs])
    along = np.array([dof.direction == "Y" for dof in system.dofs])
    turning = np.where(along, points[:, 0], [dof.direction == "RZ" for dof in system.dofs])
    bars = [bar_of(BEAM, member) for member in BEAM.members]
    inertia = sum(bar.density * bar.second_moment * bar.length for bar in bars)
    assert turning @ change @ turning == pytest.approx(inertia, rel=1e-9)  # of a rigid turn


@pytest.mark.parametrize("name", ["bay", "cantilever"])
def test_members_of_a_frame_shear_in_their_own_axes(name: str) -> None:
    structure = STRUCTURES[name]()
    theirs = replace(structure, members=tuple(replace(m, element="timoshenko") for m in structure.members))
    found, wanted = assemble(structure).sheared(1.0), assemble(theirs)
    for part in ("mass", "stiffness"):
        expected = getattr(wanted, part).toarray()
        np.testing.assert_allclose(
            getattr(found, part).toarray(), expected, rtol=0, atol=1e-12 * np.abs(expected).max()
        )
    # what is his already gains nothing
    np.testing.assert_allclose(
        wanted.sheared(0.7).stiffness.toarray(), wanted.stiffness.toarray(), rtol=1e-15
    )


def test_of_two_members_the_joint_is_at_the_end_of_either() -> None:
    system = assemble(BEAM)
    near(response(system.add_joint(7, 1e-4, member=7)), response(system.add_joint(7, 1e-4)))


def test_a_joint_is_at_the_end_of_a_member_that_is_there() -> None:
    with pytest.raises(InvalidInputError, match="member 3") as caught:
        assemble(BEAM).add_joint(7, 1e-3, member=3)
    assert caught.value.context["allowed"] == [6, 7]


def test_a_joint_needs_two_members() -> None:
    with pytest.raises(InvalidInputError, match="node 1"):
        assemble(BEAM).add_joint(1, 1e-3)
