"""What docs/updating.md tells to type."""

from typing import Any

import numpy as np
import pytest

from tests.pages import Check, outcomes


def corrected_matrices_have_the_modes_that_were_used(names: dict[str, Any]) -> None:
    # the method is exact for shapes at all DoFs: left is rounding, with eigenvalues up to 1e6 of the lowest
    assert names["direct"].reproduced < 1e-8


def the_share_of_the_correction_that_no_member_carries_is_that_of_the_matrices(names: dict[str, Any]) -> None:
    updates = names["lab"].updates
    matrices = updates.matrices(updates.list()[-1].id)  # of the first update
    nodes = np.array([int(dof.split(":")[0]) for dof in matrices.dofs])
    apart = np.abs(nodes[:, None] - nodes) > 1  # a member of the beam joins a node and the next
    for kind, lost in names["direct"].connectivity_loss.items():
        error = getattr(matrices, f"{kind}_error")
        own = np.diag(getattr(matrices, kind) - error)
        even = error / np.sqrt(np.outer(own, own))  # DoFs of both units count alike
        # errors are 1e-4 of the matrices that they are the difference of: they hold 1e4 times the rounding
        np.testing.assert_allclose(lost, np.linalg.norm(even[apart]) / np.linalg.norm(even), rtol=1e-6)
        # modes move all nodes and know no members: 61 of 441 pairs of nodes are joined, and most is elsewhere
        assert lost > 0.5


def modes_that_were_not_used_are_no_better(names: dict[str, Any]) -> None:
    other, measured = names["direct"].other_modes, names["modes"].frequencies[4:]
    assert len(other.before) == len(other.after) == 42 - 2 - 4  # DoFs, rigid bodies, modes used
    own = names["lab"].structures.modes(names["model"].id, 8).frequencies[4:]
    np.testing.assert_allclose(other.before[:4], own, rtol=1e-9)  # two eigensolvers
    before, after = (np.abs(found[:4] / measured - 1) for found in (other.before, other.after))
    # these keep their shapes to a MAC of 0.998: the correction hardly acts on them
    np.testing.assert_allclose(after, before, rtol=0.1)


def the_node_between_the_stiffer_members_is_named_first(names: dict[str, Any]) -> None:
    errors = names["located"].dof_errors["force_balance"]
    assert len(names["located"].dofs) == len(errors) == 42
    # members 11 and 12 meet at node 12
    worst = names["worst"]
    assert (worst.dof, worst.error) == ("12:+Y", max(item.error for item in errors))
    # expansion puts what was not measured where the model leaves no forces over: only rounding is left
    assert max(item.error for item in errors if item.dof.endswith("RZ")) < 1e-9
    # moments of the wrong members, at nodes 11 to 13, stand as forces around them; further off they die out
    far = [item.error for item in errors if abs(int(item.dof.split(":")[0]) - 12) > 4]
    assert max(far) < worst.error / 10


def lossy_members_are_found_with_the_stiffer_ones(names: dict[str, Any]) -> None:
    update = names["update"]
    assert update.converged
    for part, unchanged, wrong in (
        ("mass", 1.0, {}),
        ("stiffness", 1.0, {12: 2.0, 13: 2.0, 31: 2.0}),
        ("damping", 0.0, {1: 0.05, 2: 0.05}),
    ):
        for member, value in update.coefficients[part].items():
            # exact modes: quadratic convergence below the tolerance of the last step, 1e-4
            assert value == pytest.approx(wrong.get(member, unchanged), abs=1e-6)
        assert set(wrong) <= set(update.suspected[part])


def all_coefficients_at_once_find_the_wrong_members_and_no_other(names: dict[str, Any]) -> None:
    update, wrong = names["at_once"], {("mass", 25): 1.5, ("mass", 26): 1.5}
    wrong |= {("stiffness", member): 2.0 for member in (12, 13, 31)}
    assert update.converged
    assert update.suspected == {"mass": (25, 26), "stiffness": (12, 13, 31)}
    for (part, member), value in wrong.items():
        # four standard errors: they hold 91 % within two, as the guide says
        assert abs(update.coefficients[part][member] - value) < 4 * update.standard_errors[part][member]


def a_study_finds_the_wrong_members_at_every_level_and_worse_with_more_noise(names: dict[str, Any]) -> None:
    study = names["study"]
    little, much = study.cells
    assert (little.level, much.level) == ("NL2", "NL4")
    for cell in study.cells:
        assert (cell.n_runs, cell.n_failed, cell.suspected) == (2, 0, 1.0)
    # the same draws, five times as large: errors grow with them, by far more than twice
    assert much.coefficient_error[0] > 2 * little.coefficient_error[0]
    assert names["table"].splitlines()[0].split()[:3] == ["level", "division", "runs"]
    assert study.wrong == {"mass": {25: 1.5, 26: 1.5}, "stiffness": {12: 2.0, 13: 2.0, 31: 2.0}}


def the_guides_example_of_a_direction_is_named(names: dict[str, Any]) -> None:
    told = names["at_once"].identifiability.directions
    assert any("mass and stiffness of 10-12" in one.words for one in told)
    assert all(one.standard_error > 0.3 for one in told)
    wrong = {"mass": (25, 26), "stiffness": (12, 13, 31)}
    ends = [names["at_once"].intervals[part][member] for part in wrong for member in wrong[part]]
    inside = [low <= value <= high for (low, high), value in zip(ends, (1.5, 1.5, 2, 2, 2), strict=True)]
    assert sum(inside) >= 4  # each with 95 %: two of five outside in one draw of 50


def a_thickness_is_found_and_no_modulus(names: dict[str, Any]) -> None:
    found = {(one.part, one.members[0]): one for one in names["sized"].quantities}
    # six exact modes at thirteen places, four coefficients: rounding
    assert found["thickness", 49].after == pytest.approx(0.0048, rel=1e-6)
    assert found["modulus", 49].after == pytest.approx(2.09e11, rel=1e-6)
    assert found["thickness", 1].after == pytest.approx(0.004, rel=1e-6)


def a_mass_is_found_at_its_node(names: dict[str, Any]) -> None:
    (found,) = names["weighed"].quantities
    assert (found.members, found.unit) == ((117,), "kg")
    assert found.after == pytest.approx(0.08, rel=1e-6)  # exact modes, one coefficient: rounding


def draws_lie_round_what_the_update_found(names: dict[str, Any]) -> None:
    likely, draws = names["likely"], names["draws"]
    assert draws.draws.shape[1] == len(draws.coefficients) == len(likely.posterior.coefficients) == 3
    for one, column in zip(likely.posterior.coefficients, draws.draws.T, strict=True):
        assert one.mean == pytest.approx(column.mean())
        assert one.interval == pytest.approx(tuple(np.quantile(column, (0.025, 0.975))))
        found = likely.coefficients[one.part][one.members[0]]
        assert column.min() < found < column.max()


def a_joint_is_found_at_its_node(names: dict[str, Any]) -> None:
    (found,) = names["joint"].quantities
    assert (found.members, found.unit) == ((11,), "N m/rad")
    assert found.after == pytest.approx(1.2e4, rel=1e-6)  # exact modes, one coefficient: rounding


def responses_name_the_stiffer_members_without_modes(names: dict[str, Any]) -> None:
    found = names["on_lines"]
    assert found.suspected["stiffness"] == (11, 12)
    # 21 responses at 400 lines: 1 +- 0.008, and what leakage or common noise there is
    assert abs(found.responses.after - 1) < 0.1
    assert found.responses.before > 100


def members_in_macro_elements_by_a_rule_are_found(names: dict[str, Any]) -> None:
    found = names["parted"]
    assert set(range(1, 9)) <= set(found.suspected["mass"])
    assert len(found.coefficients["mass"]) == 96
    # exact modes, members of suspected macro elements one by one: the tolerance of the iteration
    for member, value in found.coefficients["mass"].items():
        assert value == pytest.approx(1.5 if member < 9 else 1.0, abs=1e-4)


CHECKS = [
    corrected_matrices_have_the_modes_that_were_used,
    the_share_of_the_correction_that_no_member_carries_is_that_of_the_matrices,
    modes_that_were_not_used_are_no_better,
    the_node_between_the_stiffer_members_is_named_first,
    lossy_members_are_found_with_the_stiffer_ones,
    all_coefficients_at_once_find_the_wrong_members_and_no_other,
    a_study_finds_the_wrong_members_at_every_level_and_worse_with_more_noise,
    the_guides_example_of_a_direction_is_named,
    a_thickness_is_found_and_no_modulus,
    a_mass_is_found_at_its_node,
    draws_lie_round_what_the_update_found,
    a_joint_is_found_at_its_node,
    responses_name_the_stiffer_members_without_modes,
    members_in_macro_elements_by_a_rule_are_found,
]


@pytest.fixture(scope="module")
def found_wrong(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What each check found wrong after the page ran in a new interpreter and an empty folder."""
    return outcomes("updating.md", tmp_path_factory.mktemp("guide"), CHECKS)


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_the_examples_give_what_the_page_says(check: Check, found_wrong: dict[str, str]) -> None:
    assert not found_wrong[check.__name__], found_wrong[check.__name__]
