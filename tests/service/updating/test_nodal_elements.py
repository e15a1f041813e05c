"""Masses and mounts that a model has are found at their nodes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import GroundSpringElement, PointMass, Structure
from modallab.updating.method import UPDATERS
from modallab.updating.nodal_elements import nodal_values, node_matrices, with_scaled_nodes
from modallab.updating.options import UpdateOptions
from modallab.updating.parameterisation import MacroElement, Part, at_nodes, parameterise
from modallab.updating.studies.truth import true_coefficients
from tests.service.updating.cases import BEAM_DOFS, modes_of

BEAM = replace(STRUCTURES["chapter-5-beam"](), damping=StructuralDamping())
MODEL = replace(
    BEAM,
    masses=(PointMass(7, 0.05), PointMass(15, 0.1)),
    springs=(
        GroundSpringElement(Dof(1, "Y"), 1e5),
        GroundSpringElement(Dof(1, "RZ"), 100.0),
        GroundSpringElement(Dof(21, "Y", -1), 2e4),
    ),
)
TRUTH = replace(
    MODEL,
    masses=(PointMass(7, 0.08), PointMass(15, 0.1)),
    springs=(
        GroundSpringElement(Dof(1, "Y"), 1.5e5),
        GroundSpringElement(Dof(1, "RZ"), 60.0),
        MODEL.springs[2],
    ),
)
ALL = at_nodes(MODEL, {"point_mass": None, "ground_spring_y": None, "ground_spring_rz": None})
GROUPS = [tuple(range(first, first + 4)) for first in range(1, 21, 4)]
EXACT = 1e-6  # noise-free modes: rounding, times the condition of the equations


@pytest.mark.parametrize("groups", [[], GROUPS], ids=["alone", "with mass and stiffness of members"])
@pytest.mark.parametrize("method", [name for name in UPDATERS if not name.startswith("complex")])
def test_what_nodes_carry_is_found_in_its_unit(method: str, groups: Sequence[tuple[int, ...]]) -> None:
    parameters = parameterise(groups, nodal=ALL)
    options = UpdateOptions(tolerance=1e-9)
    result = UPDATERS[method](MODEL, parameters, modes_of(TRUTH, 6, BEAM_DOFS), options=options)
    assert result.coefficients["point_mass"][7] == pytest.approx(1.6, abs=EXACT)
    assert result.coefficients["ground_spring_y"][1] == pytest.approx(1.5, abs=EXACT)
    assert result.coefficients["ground_spring_rz"][1] == pytest.approx(0.6, abs=EXACT)
    told = {(one.part.value, one.members): one for one in result.quantities}
    assert told["point_mass", (7,)].after == pytest.approx(0.08, rel=EXACT)
    assert (told["point_mass", (7,)].unit, told["ground_spring_rz", (1,)].unit) == ("kg", "N m/rad")
    assert [one.mass for one in result.structure.masses] == pytest.approx([0.08, 0.1], rel=EXACT)
    found = [one.stiffness for one in result.structure.springs]
    assert found == pytest.approx([1.5e5, 60.0, 2e4], rel=EXACT)
    assert result.structure.members == MODEL.members or groups


@pytest.mark.parametrize("method", ["complex_inverse_eigensensitivity", "complex_one_shot"])
def test_what_nodes_carry_is_found_from_damped_modes(method: str) -> None:
    model, truth = (replace(one, damping=StructuralDamping(0.05)) for one in (MODEL, TRUTH))
    parameters = parameterise([], nodal=ALL)
    options = UpdateOptions(tolerance=1e-9)
    result = UPDATERS[method](model, parameters, modes_of(truth, 6, BEAM_DOFS), options=options)
    for part, node, factor in (("point_mass", 7, 1.6), ("ground_spring_rz", 1, 0.6)):
        assert result.coefficients[part][node] == pytest.approx(factor, abs=EXACT)


def test_nodes_and_members_of_one_number_are_told_apart_in_words() -> None:
    parameters = parameterise([(7,)], ("density",), nodal=at_nodes(MODEL, {"point_mass": [(7,)]}))
    assert [str(macro) for macro in parameters.macros] == ["density of 7", "point_mass of node 7"]
    clamped = STRUCTURES["cantilever"]()
    carrying = replace(clamped, masses=(PointMass(2, 0.1), PointMass(11, 0.05)))
    heavy = parameterise([], nodal=at_nodes(carrying, {"point_mass": None}))
    result = UPDATERS["one_shot"](carrying, heavy, modes_of(carrying, 2, (Dof(6, "Y"), Dof(11, "Y"))))
    assert result.identifiability is not None
    words = [one.words for one in result.identifiability.directions]
    # next to the clamp nothing moves: to two modes a mass there is as good as none
    assert any(one.startswith("point mass of node 2 ") for one in words), words


def test_masses_at_one_node_and_springs_in_one_direction_are_one() -> None:
    twice = replace(MODEL, masses=(*MODEL.masses, PointMass(7, 0.01)))
    assert nodal_values(twice, Part.POINT_MASS) == {7: pytest.approx(0.06), 15: 0.1}
    assert nodal_values(twice, Part.GROUND_SPRING_Y) == {1: 1e5, 21: 2e4}
    assert nodal_values(twice, Part.GROUND_SPRING_X) == {}
    heavier = with_scaled_nodes(twice, Part.POINT_MASS, (7,), 2.0)
    assert [one.mass for one in heavier.masses] == [0.1, 0.1, 0.02]
    stiffer = with_scaled_nodes(twice, Part.GROUND_SPRING_Y, (1,), 2.0)
    assert [one.stiffness for one in stiffer.springs] == [2e5, 100.0, 2e4]


def test_a_mass_moves_with_every_translation_of_its_node() -> None:
    bay: Structure = replace(STRUCTURES["bay"](), masses=(PointMass(4, 0.3),))
    matrices, rows = node_matrices(bay, Part.POINT_MASS, (4,))
    np.testing.assert_array_equal(matrices[0], 0.3 * np.eye(3))
    assert rows[0].tolist() == [bay.index(Dof(4, "X")), bay.index(Dof(4, "Y")), -1]


def test_a_study_looks_for_what_nodes_carry() -> None:
    true = true_coefficients(MODEL, TRUTH, (Part.MASS, Part.POINT_MASS, Part.GROUND_SPRING_Y))
    assert true["point_mass"] == {7: pytest.approx(1.6), 15: 1.0}
    assert true["ground_spring_y"] == {1: pytest.approx(1.5), 21: 1.0}
    with pytest.raises(InvalidInputError, match="node 7 carries no point mass"):
        true_coefficients(MODEL, replace(TRUTH, masses=TRUTH.masses[1:]), (Part.POINT_MASS,))


@pytest.mark.parametrize(
    ("part", "groups", "words"),
    [
        ("point_mass", [(3,)], "node 3 carries no point mass"),
        ("ground_spring_x", [(1,)], "node 1 carries no ground spring X"),
        ("ground_spring_x", None, "no node carries a ground spring X"),
        ("point_mass", [()], "point_mass is of no node"),
        ("mass", [(7,)], "nodes carry no 'mass'"),
    ],
)
def test_what_nodes_do_not_carry_is_refused(
    part: str, groups: list[tuple[int, ...]] | None, words: str
) -> None:
    with pytest.raises(InvalidInputError, match=words) as caught:
        parameterise([], nodal=at_nodes(MODEL, {part: groups})).groups(MODEL)
    assert caught.value.context["field"] == "attached"
    assert caught.value.context["allowed"]


def test_a_node_has_one_coefficient_of_a_mass_and_no_member_has_any() -> None:
    with pytest.raises(InvalidInputError, match="two coefficients of its point mass"):
        parameterise([], nodal=(MacroElement((7, 15), Part.POINT_MASS), MacroElement((7,), Part.POINT_MASS)))
    with pytest.raises(InvalidInputError, match="elements have no part 'point_mass'"):
        parameterise([(1,)], ("point_mass",))
