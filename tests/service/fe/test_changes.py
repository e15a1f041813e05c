"""Changes make new structures: what they do to matrices and modes, and what they refuse."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import (
    Change,
    GroundStiffness,
    JointStiffness,
    MemberChange,
    MemberProperty,
    NodeMass,
    change,
)
from modallab.fe.damping import ViscousDamping
from modallab.fe.structure import Structure

BEAM, BAY = STRUCTURES["chapter-5-beam"](), STRUCTURES["bay"]()
P = MemberProperty


def frequencies(structure: Structure) -> np.ndarray:
    return assemble(structure).modes().elastic(6).frequencies


def members(structure: Structure) -> tuple[int, ...]:
    return tuple(member.number for member in structure.members)


@pytest.mark.parametrize(
    ("prop", "factor", "expected"),
    [(P.DENSITY, 4.0, 0.5), (P.MODULUS, 4.0, 2.0), (P.BENDING_STIFFNESS, 4.0, 2.0)],
)
def test_a_property_of_every_member_scales_a_beam(
    prop: MemberProperty, factor: float, expected: float
) -> None:
    changed = change(BEAM, [MemberChange(members(BEAM), prop, factor=factor)])
    np.testing.assert_allclose(frequencies(changed), expected * frequencies(BEAM), rtol=1e-6)


def test_modulus_is_axial_and_bending_stiffness_together() -> None:
    together = change(BAY, [MemberChange((12, 13), P.MODULUS, factor=2.0)])
    apart = change(
        BAY,
        [
            MemberChange((12, 13), P.AXIAL_STIFFNESS, factor=2.0),
            MemberChange((12, 13), P.BENDING_STIFFNESS, factor=2.0),
        ],
    )
    assert together.members == apart.members


@pytest.mark.parametrize(
    ("prop", "value", "attribute"),
    [
        (P.DENSITY, 2 * 2800.0, "mass_factor"),
        (P.MODULUS, 2 * 7.5e10, "axial_factor"),
        (P.MODULUS, 2 * 7.5e10, "bending_factor"),
        (P.AXIAL_STIFFNESS, 2 * 7.5e10 * 4e-3, "axial_factor"),
        (P.BENDING_STIFFNESS, 2 * 7.5e10 * 7.56e-2, "bending_factor"),
    ],
)
def test_a_value_is_set_whatever_went_before(prop: MemberProperty, value: float, attribute: str) -> None:
    before = MemberChange((3,), prop, factor=7.0)
    changed = change(BAY, [before, MemberChange((3,), prop, value=value)])
    assert getattr(changed.member(3), attribute) == pytest.approx(2.0, rel=1e-12)


def test_factors_multiply_one_another() -> None:
    twice = [MemberChange((3, 4), P.DENSITY, factor=1.5), MemberChange((4,), P.DENSITY, factor=2.0)]
    changed = change(BAY, twice)
    assert [changed.member(n).mass_factor for n in (2, 3, 4)] == [1.0, 1.5, 3.0]


@pytest.mark.parametrize(("prop", "now"), [(P.AREA, 4e-3), (P.SECOND_MOMENT, 7.56e-2)])
def test_a_size_of_a_section_is_multiplied_or_set(prop: MemberProperty, now: float) -> None:
    section = BAY.members[2].section
    assert getattr(section, prop) == now
    for made, expected in (
        (MemberChange((3,), prop, factor=2.0), 2 * now),
        (MemberChange((3,), prop, value=0.01), 0.01),
    ):
        member = change(BAY, [made]).members[2]
        own: dict[str, Any] = {prop.value: expected}
        assert member.section == replace(section, **own)
        assert (member.mass_factor, member.axial_factor, member.bending_factor) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_thin_plate_rises_as_its_thickness(factor: float) -> None:
    flat = STRUCTURES["plate"]()
    every = tuple(member.number for member in flat.non_bar_members)
    thicker = change(flat, [MemberChange(every, P.THICKNESS, factor=factor)])
    # of Kirchhoff's plate omega goes as t; what shears and turns is (t / size)^2 of it
    np.testing.assert_allclose(frequencies(thicker), factor * frequencies(flat), rtol=2e-3)


def test_a_loss_factor_replaces_the_laws_and_is_multiplied_from_it() -> None:
    set_, doubled = (
        change(BEAM, [MemberChange((1,), P.LOSS_FACTOR, value=0.05)]),
        change(BEAM, [MemberChange((1,), P.LOSS_FACTOR, factor=2.0)]),
    )
    assert set_.member(1).loss_factor == 0.05
    assert doubled.member(1).loss_factor == pytest.approx(2 * 0.005)


def test_a_mass_at_a_node_is_set_and_taken_away() -> None:
    loaded = change(BEAM, [NodeMass(7, 0.05)])
    attached = assemble(BEAM).add_mass(7, 0.05).modes().elastic(6).frequencies
    np.testing.assert_allclose(frequencies(loaded), attached, rtol=1e-9)
    assert change(loaded, [NodeMass(7, 0.02)]).masses[0].mass == 0.02
    assert change(loaded, [NodeMass(7, 0.0)]).masses == ()


def test_a_spring_to_ground_is_set_and_taken_away() -> None:
    held = change(BEAM, [GroundStiffness(Dof(1, "Y", -1), 1e4)])
    attached = assemble(BEAM).add_spring(Dof(1, "Y"), 1e4).modes().elastic(6).frequencies
    np.testing.assert_allclose(frequencies(held), attached, rtol=1e-9)
    assert change(held, [GroundStiffness(Dof(1, "Y"), 0.0)]).springs == ()


def test_a_joint_at_a_node_is_set() -> None:
    loose = change(BEAM, [JointStiffness(11, 1e3), JointStiffness(11, 2e4)])
    attached = assemble(BEAM).add_joint(11, 1 / 2e4).modes().elastic(6).frequencies
    np.testing.assert_allclose(frequencies(loose), attached, rtol=1e-9)


def test_the_structure_changed_stays_as_it_was() -> None:
    before = frequencies(BEAM)
    change(BEAM, [MemberChange((1,), P.MODULUS, factor=2.0), NodeMass(3, 1.0)])
    np.testing.assert_array_equal(frequencies(BEAM), before)


WRONG: dict[str, tuple[Callable[[], Change], str]] = {
    "an unknown member": (lambda: MemberChange((1, 99), P.MODULUS, factor=2.0), "members"),
    "no member": (lambda: MemberChange((), P.MODULUS, factor=2.0), "members"),
    "an unknown property": (lambda: MemberChange((1,), "colour", factor=2.0), "property"),  # type: ignore[arg-type]
    "neither factor nor value": (lambda: MemberChange((1,), P.MODULUS), "factor"),
    "both factor and value": (lambda: MemberChange((1,), P.MODULUS, factor=2.0, value=1e11), "factor"),
    "a factor of zero": (lambda: MemberChange((1,), P.MODULUS, factor=0.0), "factor"),
    "a negative value": (lambda: MemberChange((1,), P.LOSS_FACTOR, value=-0.1), "value"),
    "an infinite value": (lambda: MemberChange((1,), P.DENSITY, value=float("inf")), "value"),
    "a thickness of a bar": (lambda: MemberChange((1,), P.THICKNESS, factor=2.0), "property"),
    "a factor on no loss factor": (lambda: MemberChange((1,), P.LOSS_FACTOR, factor=2.0), "factor"),
    "a mass at an unknown node": (lambda: NodeMass(99, 1.0), "node"),
    "a negative mass": (lambda: NodeMass(1, -1.0), "value"),
    "a spring on an unknown DoF": (lambda: GroundStiffness(Dof(1, "Z"), 1.0), "dof"),
    "a joint at an unknown node": (lambda: JointStiffness(99, 1e4), "dof"),
    "a joint at an end": (lambda: JointStiffness(1, 1e4), "joints"),
    "a joint that is a hinge": (lambda: JointStiffness(11, 0.0), "value"),
    "a negative spring": (lambda: GroundStiffness(Dof(1, "Y"), -1.0), "value"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_has_no_meaning_is_refused_by_field(case: str) -> None:
    make, field = WRONG[case]
    viscous = replace(BEAM, damping=ViscousDamping(1e-6))  # its members have no loss factor
    with pytest.raises(InvalidInputError) as caught:
        change(viscous, [make()])
    assert caught.value.context["field"] == field
    assert "allowed" in caught.value.context
