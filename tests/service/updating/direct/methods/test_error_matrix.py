"""The error matrix method."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.errors import UnderdeterminedError
from modallab.fe.changes import MemberChange, MemberProperty, change
from tests.service.updating.direct.cases import BEAM, BOTH, STIFFER, SYSTEM, located, problem, wrong_rows

ALL = len(SYSTEM.dofs)


def test_with_all_modes_a_small_error_is_found_to_second_order() -> None:
    size = 1e-3
    slightly = change(
        BEAM,
        [
            MemberChange((11,), MemberProperty.MODULUS, factor=1 + size),
            MemberChange((5,), MemberProperty.DENSITY, factor=1 + size),
        ],
    )
    found, truth = located("error_matrix", problem(slightly, ALL)), problem(BEAM, 1, model=slightly)
    for name in ("mass", "stiffness"):
        error = getattr(truth, name) - getattr(problem(BEAM, 1), name)
        # the neglected part is as much smaller than the error as that is than the matrix
        np.testing.assert_allclose(found.matrices[name], error, atol=5 * size * np.abs(error).max())


@pytest.mark.parametrize("matrix", ["mass", "stiffness"])
def test_with_all_modes_the_wrong_dofs_come_first(matrix: str) -> None:
    shares, wrong = located("error_matrix", problem(BOTH, ALL)).dof_errors[matrix], wrong_rows(BOTH, matrix)
    assert set(np.argsort(-shares)[: len(wrong)].tolist()) == wrong


def test_a_few_modes_point_at_stiffer_members() -> None:
    shares, wrong = (
        located("error_matrix", problem(STIFFER, 5)).dof_errors["stiffness"],
        wrong_rows(STIFFER, "stiffness"),
    )
    assert set(np.argsort(-shares)[:2].tolist()) <= wrong


def test_a_model_with_the_measured_modes_has_no_error() -> None:
    given = problem(BEAM, 5)
    found = located("error_matrix", given)
    for name, own in (("mass", given.mass), ("stiffness", given.stiffness)):
        np.testing.assert_allclose(found.matrices[name], 0.0, atol=1e-9 * np.abs(own).max())  # rounding
        np.testing.assert_allclose(found.dof_errors[name], 0.0, atol=1e-6)


def test_the_sense_of_a_shape_does_not_matter() -> None:
    given = problem(BOTH, 5)
    turned = replace(given, shapes=given.shapes * [1, -1, 1, -1, -1])
    for name, matrix in located("error_matrix", given).matrices.items():
        np.testing.assert_array_equal(located("error_matrix", turned).matrices[name], matrix)


def test_a_mode_without_a_partner_is_refused() -> None:
    given = problem(BOTH, 5)
    unlike = given.shapes.copy()
    unlike[:, 2] = given.model_shapes[:, 7]
    with pytest.raises(UnderdeterminedError, match="mode 3"):
        located("error_matrix", replace(given, shapes=unlike))
