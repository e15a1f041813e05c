from collections.abc import Sequence

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.diagnosis.searching.backward_elimination import Group, backward_elimination


def problem(numbers: list[float], *, noise: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Return 400 lines of six columns and a target of unit noise that they explain with some numbers."""
    rng = np.random.default_rng(3)
    slopes = rng.normal(size=(400, len(numbers)))
    return slopes, slopes @ np.array(numbers) + noise * rng.normal(size=400)


def neighbours(one: Sequence[int], other: Sequence[int]) -> bool:
    return min(abs(i - j) for i in one for j in other) == 1


def test_only_columns_that_explain_something_are_kept_and_neighbours_with_one_number_are_one() -> None:
    groups = backward_elimination(*problem([0.0, 2.0, 2.0, 0.0, -3.0, 0.0]), neighbours)
    assert {group.columns for group in groups} == {(1, 2), (4,)}
    found = {group.columns: group.value for group in groups}
    # Standard errors are 1/sqrt(800) and 1/sqrt(400).
    assert found[1, 2] == pytest.approx(2.0, abs=4 / np.sqrt(800))
    assert found[4,] == pytest.approx(-3.0, abs=4 / np.sqrt(400))


def test_neighbours_with_numbers_that_differ_stay_apart() -> None:
    groups = backward_elimination(*problem([0.0, 2.0, 3.0, 0.0, 0.0, 0.0]), neighbours)
    assert {group.columns for group in groups} == {(1,), (2,)}


def test_columns_that_are_not_neighbours_stay_apart() -> None:
    groups = backward_elimination(*problem([2.0, 0.0, 2.0, 0.0, 0.0, 0.0]), neighbours)
    assert {group.columns for group in groups} == {(0,), (2,)}


def test_noise_needs_no_column() -> None:
    assert backward_elimination(*problem([0.0] * 6), neighbours) == []


def test_columns_that_say_the_same_share_what_one_of_them_explains() -> None:
    slopes, target = problem([0.0, 2.0, 0.0])
    (group,) = backward_elimination(np.hstack([slopes, slopes[:, [1]]]), target, neighbours)
    assert group in (Group((1,), group.value), Group((3,), group.value))
    assert group.value == pytest.approx(2.0, abs=4 / np.sqrt(400))
