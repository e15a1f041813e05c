"""A structure is checked once, when it is made."""

from collections.abc import Callable

import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnknownDofError
from modallab.fe.beam import beam
from modallab.fe.damping import ModalDamping, StructuralDamping, ViscousDamping
from modallab.fe.structure import (
    GroundSpringElement,
    Material,
    Member,
    PointMass,
    Section,
    Structure,
    Support,
)

SECTION, STEEL = Section(5e-4, 4e-9), Material(2e11, 7800.0)
CORNERS = {1: (0.0, 0.0), 2: (1.0, 0.0), 3: (1.0, 1.0), 4: (0.0, 1.0)}


def bar(number: int, start: int, end: int) -> Member:
    return Member(number, (start, end), SECTION, STEEL)


def frame(
    *members: Member,
    nodes: dict[int, tuple[float, float]] = CORNERS,
    supports: tuple[Support, ...] = (),
    masses: tuple[PointMass, ...] = (),
    springs: tuple[GroundSpringElement, ...] = (),
) -> Structure:
    return Structure(nodes, members, supports, masses, springs)


PATH = (bar(1, 1, 2), bar(2, 2, 3), bar(3, 3, 4))
ALL = ("X", "Y", "RZ")

WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "two parts that nothing joins": (lambda: frame(bar(1, 1, 2), bar(2, 3, 4)), "members"),
    "a node without a member": (lambda: frame(bar(1, 1, 2), bar(2, 2, 3)), "members"),
    "no members": (lambda: frame(), "members"),
    "no nodes": (lambda: frame(bar(1, 1, 2), nodes={}), "members"),
    "a member to an unknown node": (lambda: frame(*PATH, bar(4, 4, 9)), "members"),
    "a member of no length": (lambda: frame(*PATH, bar(4, 1, 1)), "members"),
    "a member number twice": (lambda: frame(*PATH, bar(1, 4, 1)), "members"),
    "a node at no place": (lambda: frame(*PATH, nodes={**CORNERS, 4: (float("nan"), 0.0)}), "nodes"),
    "a node beyond the horizon": (lambda: frame(*PATH, nodes={**CORNERS, 4: (1e200, 0.0)}), "nodes"),
    "every DoF held": (lambda: frame(*PATH, supports=tuple(Support(n, ALL) for n in CORNERS)), "supports"),
    "a support at an unknown node": (lambda: frame(*PATH, supports=(Support(9, ALL),)), "supports"),
    "a support in an unknown direction": (lambda: frame(*PATH, supports=(Support(1, ("Q",)),)), "supports"),
    "a mass at an unknown node": (lambda: frame(*PATH, masses=(PointMass(9, 1.0),)), "masses"),
    "a negative mass": (lambda: frame(*PATH, masses=(PointMass(1, -1.0),)), "mass"),
    "a mass that is no number": (lambda: frame(*PATH, masses=(PointMass(1, float("nan")),)), "mass"),
    "a negative spring": (
        lambda: frame(*PATH, springs=(GroundSpringElement(Dof(1, "Y"), -1.0),)),
        "stiffness",
    ),
    "a negative area": (lambda: Section(-5e-4, 4e-9), "area"),
    "no second moment": (lambda: Section(5e-4, 0.0), "second_moment"),
    "a modulus that is no number": (lambda: Material(float("nan"), 7800.0), "modulus"),
    "a density of nothing": (lambda: Material(2e11, 1e-300), "density"),
    "a negative factor": (lambda: Member(1, (1, 2), SECTION, STEEL, mass_factor=-1.0), "mass_factor"),
    "a negative loss factor": (lambda: Member(1, (1, 2), SECTION, STEEL, loss_factor=-0.1), "loss_factor"),
    "a beam of no length": (
        lambda: beam(length=0.0, n_elements=4, section=SECTION, material=STEEL),
        "length",
    ),
    "a beam of no elements": (
        lambda: beam(length=1.0, n_elements=0, section=SECTION, material=STEEL),
        "n_elements",
    ),
    "negative structural damping": (lambda: StructuralDamping(-0.1), "stiffness_coefficient"),
    "negative viscous damping": (lambda: ViscousDamping(0.0, -0.1), "mass_coefficient"),
    "damping without bounds": (lambda: StructuralDamping(1e300), "stiffness_coefficient"),
    "no modal damping": (lambda: ModalDamping(()), "loss_factors"),
    "negative modal damping": (lambda: ModalDamping((0.1, -0.1)), "loss_factors"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_analysed_is_refused_by_field(case: str) -> None:
    make, field = WRONG[case]
    with pytest.raises(InvalidInputError) as caught:
        make()
    assert caught.value.context["field"] == field


def test_an_unknown_dof_is_named_with_those_there_are() -> None:
    structure = frame(*PATH, supports=(Support(1, ("X",)),))
    with pytest.raises(UnknownDofError) as caught:
        structure.index(Dof(1, "X"))
    assert caught.value.context == {"field": "dof", "value": "1:+X", "allowed": ["1:+Y", "1:+RZ"]}


def test_changing_the_nodes_handed_in_changes_nothing() -> None:
    nodes = dict(CORNERS)
    structure = frame(*PATH, nodes=nodes)
    nodes[1] = (5.0, 5.0)
    assert structure.nodes[1] == (0.0, 0.0)
