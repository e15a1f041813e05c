"""Imported matrices: the same modes, updates by groups, and what is refused."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csc_array

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import StructureError
from modallab.fe import imported_elements as imported
from modallab.fe.assembly import Assembly, assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.damping import StructuralDamping
from modallab.fe.imported_elements import Element, GroupMatrices, of_elements, of_groups
from modallab.fe.plate import plate
from modallab.fe.structure import Material, Structure
from modallab.fe.structure_settings import INPUT
from modallab.fe.synthetic_modes import exact_modes, lowest_modes
from modallab.store.plain import from_plain, to_plain
from modallab.updating.method import UPDATERS
from modallab.updating.parameterisation import parameterise
from modallab.updating.partitioning import automatic_groups, named_groups

BAY = STRUCTURES["bay"]()
PLATE = plate(length=0.6, width=0.4, thickness=0.004, n_elements=(12, 8), material=Material(2.09e11, 7800.0))


def group_of(structure: Structure, name: str, numbers: Sequence[int]) -> GroupMatrices:
    """What some members of a structure add to its matrices."""
    whole = Assembly(structure)
    chosen = np.array([m.number in numbers for m in structure.all_members], float)[:, None, None]
    return GroupMatrices(
        name, whole.matrix(chosen * whole.mass), whole.matrix(chosen * (whole.axial + whole.bending))
    )


def in_two(structure: Structure) -> list[GroupMatrices]:
    numbers = [m.number for m in structure.all_members]
    half = len(numbers) // 2
    return [group_of(structure, "first", numbers[:half]), group_of(structure, "second", numbers[half:])]


def frequencies(structure: Structure, count: int = 8) -> FloatArray:
    return lowest_modes(assemble(structure), count)[0].frequencies


@pytest.mark.parametrize("own", [BAY, PLATE, STRUCTURES["cantilever"]()], ids=["bay", "plate", "cantilever"])
def test_matrices_of_a_structure_have_its_modes_and_rigid_bodies(own: Structure) -> None:
    system = assemble(own)
    given = of_groups([GroupMatrices("all", system.mass, system.stiffness)], own.dofs)
    basis, n_rigid_body = lowest_modes(system, 8)
    found, rigid = lowest_modes(assemble(given), 8)
    assert rigid == n_rigid_body
    # the same matrices: rounding, times the highest eigenvalue over the lowest, up to 1e7 of the bay
    np.testing.assert_allclose(found.frequencies, basis.frequencies, rtol=1e-8)


def test_a_large_model_cut_into_pairs_of_nodes_is_the_same_model(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(imported, "INPUT", replace(INPUT, max_whole_group_values=1000))
    cut = of_groups(in_two(PLATE), PLATE.dofs)
    assert len(cut.non_bar_members) > 300
    assert set(cut.groups) == {"first", "second"}
    ours, theirs = assemble(cut), assemble(PLATE)
    for one, other in ((ours.mass, theirs.mass), (ours.stiffness, theirs.stiffness)):
        # sums in another order
        assert abs(one - other).max() < 1e-12 * abs(other).max()


def test_a_group_scaled_is_the_structure_with_its_members_scaled() -> None:
    given = of_groups(in_two(BAY), BAY.dofs)
    second = tuple(m.number for m in BAY.members[len(BAY.members) // 2 :])
    for property in (MemberProperty.MODULUS, MemberProperty.DENSITY):
        own = change(BAY, [MemberChange(second, property, factor=1.4)])
        same = change(given, [MemberChange(given.groups["second"], property, factor=1.4)])
        # rounding, as above
        np.testing.assert_allclose(frequencies(same), frequencies(own), rtol=1e-8)


def test_an_update_by_groups_finds_their_coefficients() -> None:
    given = of_groups(in_two(PLATE), PLATE.dofs)
    wrong = change(given, [MemberChange(given.groups["second"], MemberProperty.MODULUS, factor=1.3)])
    dofs = tuple(dof for dof in PLATE.dofs if dof.direction == "Z")[::5]
    target = exact_modes(assemble(wrong), 4)
    seen = [target.dofs.index(dof) for dof in dofs]
    modes = tuple(replace(mode, shape=mode.shape[seen]) for mode in target.modes)
    target = replace(target, modes=modes, dofs=dofs)
    groups = named_groups(given, ["first", "second"])
    result = UPDATERS["inverse_eigensensitivity"](given, parameterise(groups, ["stiffness"]), target)
    assert result.converged
    found = result.coefficients["stiffness"]
    # noise-free and linear in the coefficients: to the tolerance of the iteration
    assert found[given.groups["second"][0]] == pytest.approx(1.3, abs=1e-4)
    assert found[given.groups["first"][0]] == pytest.approx(1.0, abs=1e-4)
    np.testing.assert_allclose(frequencies(result.structure, 4), frequencies(wrong, 4), rtol=1e-5)


def test_groups_are_the_macro_elements_of_a_model_that_has_them() -> None:
    given = of_groups(in_two(BAY), BAY.dofs)
    assert automatic_groups(given) == ((1,), (2,))


def test_damping_is_that_of_the_law_and_of_single_elements() -> None:
    matrix = np.array([[2.0, -1.0], [-1.0, 2.0]])
    dofs = (Dof(1, "X"), Dof(2, "X"))
    common = of_elements(
        [Element(1, "a", [0, 1], np.eye(2), 1e4 * matrix)], dofs, damping=StructuralDamping(0.01)
    )
    own = of_elements([Element(1, "a", [0, 1], np.eye(2), 1e4 * matrix, loss_factor=0.03)], dofs)
    np.testing.assert_allclose(lowest_modes(assemble(common), 2)[0].loss_factors, 0.01)
    np.testing.assert_allclose(lowest_modes(assemble(own), 2)[0].loss_factors, 0.03)


def test_it_is_stored_and_read_back_as_it_was() -> None:
    given = of_groups(in_two(BAY), BAY.dofs)
    same = from_plain(Structure, *to_plain(given))
    np.testing.assert_array_equal(frequencies(same), frequencies(given))


PAIR = (Dof(1, "X"), Dof(2, "X"))
SOUND = np.array([[2.0, -1.0], [-1.0, 2.0]])
BAD = {
    "not symmetric": (
        np.eye(2),
        SOUND + np.array([[0, 0.1], [0, 0]]),
        "stiffness of element 1 is not symmetric",
    ),
    "no mass": (np.diag([1.0, 0.0]), SOUND, "1 degrees of freedom carry no mass"),
    "singular mass": (np.ones((2, 2)), SOUND, "mass matrix is not positive definite"),
    "negative mass": (np.array([[1.0, 2.0], [2.0, 1.0]]), SOUND, "mass matrix is not positive definite"),
    "negative stiffness": (np.eye(2), np.array([[1.0, 2.0], [2.0, 1.0]]), "negative for some motion"),
    "not finite": (np.eye(2), SOUND * np.nan, "not finite"),
    "beyond all": (np.eye(2), SOUND * 1e200, "of no size"),
}


@pytest.mark.parametrize("case", BAD)
def test_matrices_of_no_structure_are_refused_by_name(case: str) -> None:
    mass, stiffness, message = BAD[case]
    with pytest.raises(StructureError, match=message) as caught:
        of_elements([Element(1, "a", [0, 1], mass, stiffness)], PAIR)
    assert caught.value.context["field"] in ("mass", "stiffness")


def test_a_table_with_a_degree_of_freedom_twice_is_refused() -> None:
    matrix = csc_array(SOUND)
    with pytest.raises(StructureError, match="twice"):
        of_groups([GroupMatrices("all", matrix, matrix)], (Dof(1, "X"), Dof(1, "X")))


def test_a_model_in_parts_that_nothing_joins_is_refused() -> None:
    each = [Element(i + 1, "a", [i], np.eye(1), np.eye(1)) for i in (0, 1)]
    with pytest.raises(StructureError, match="nothing joins"):
        of_elements(each, PAIR)


def test_a_property_of_matrices_has_no_value_to_be_set_to() -> None:
    given = of_elements([Element(1, "a", [0, 1], np.eye(2), SOUND)], PAIR)
    with pytest.raises(ValueError, match="given by its matrices"):
        change(given, [MemberChange((1,), MemberProperty.MODULUS, value=7e10)])
