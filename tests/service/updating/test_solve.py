"""Steps: balanced, bounded, and honest about their rank."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.updating.solve import balanced_step, bounded_step

RNG = np.random.default_rng(7)
MATRIX = RNG.normal(size=(12, 4))
ONES = np.ones(12)


def test_a_consistent_system_is_solved_whatever_the_rows_weigh() -> None:
    wanted = np.array([0.3, -0.2, 0.1, 0.05])
    scale = 10.0 ** RNG.uniform(-6, 6, 12)
    matrix = MATRIX * scale[:, None]
    step = balanced_step(matrix, matrix @ wanted, scale)
    np.testing.assert_allclose(step.parameters, wanted, rtol=1e-10)
    assert step.rank == 4
    assert step.condition_number == pytest.approx(np.linalg.cond(MATRIX))


def test_what_the_rows_do_not_show_is_left_where_it_is() -> None:
    blind = MATRIX.copy()
    blind[:, 3] = blind[:, 2]  # only the sum of the last two shows
    step = balanced_step(blind, blind @ np.array([0.3, -0.2, 0.2, 0.0]), ONES)
    assert step.rank == 3
    np.testing.assert_allclose(step.parameters, [0.3, -0.2, 0.1, 0.1], rtol=1e-9)  # the shortest solution


def test_the_rank_ends_at_a_cliff_and_not_at_a_slope() -> None:
    u = np.linalg.qr(RNG.normal(size=(12, 4)))[0]
    slope = balanced_step(u * np.array([1.0, 1e-2, 1e-4, 1e-6]), ONES, ONES)
    cliff = balanced_step(u * np.array([1.0, 0.5, 1e-4, 1e-5]), ONES, ONES)
    assert (slope.rank, cliff.rank) == (4, 2)


def test_no_columns_that_act_give_no_step() -> None:
    step = balanced_step(np.zeros((12, 4)), ONES, ONES)
    assert step.rank == 0
    assert (step.parameters == 0).all()
    assert step.condition_number == 1.0


@settings(max_examples=60, deadline=None)
@given(
    values=st.lists(st.floats(0.05, 10.0), min_size=4, max_size=4).map(np.array),
    wanted=st.lists(st.floats(-5.0, 5.0), min_size=4, max_size=4).map(np.array),
    max_step=st.floats(0.05, 1.0),
)
def test_a_bounded_step_stays_within_its_bounds_and_its_length(
    values: np.ndarray, wanted: np.ndarray, max_step: float
) -> None:
    step = bounded_step(MATRIX, MATRIX @ wanted, ONES, values, (0.05, 10.0), max_step=max_step)
    assert (np.abs(step.parameters) <= max_step * (1 + 1e-12)).all()
    after = values + step.parameters
    assert (after >= 0.05 * (1 - 1e-12)).all()
    assert (after <= 10.0 * (1 + 1e-12)).all()


def test_a_long_step_is_shortened_as_a_whole() -> None:
    wanted = np.array([1.5, -0.3, 0.6, 0.0])
    step = bounded_step(MATRIX, MATRIX @ wanted, ONES, np.full(4, 2.0), (0.05, 10.0), max_step=0.3)
    np.testing.assert_allclose(step.parameters, 0.2 * wanted, atol=1e-12)


def test_a_parameter_on_its_bound_does_not_hold_up_the_others() -> None:
    values = np.array([0.05, 1.0, 1.0, 1.0])
    step = bounded_step(
        MATRIX, MATRIX @ np.array([-1.0, 0.2, 0.1, 0.0]), ONES, values, (0.05, 10.0), max_step=1.0
    )
    assert step.parameters[0] == 0
    expected = np.linalg.lstsq(MATRIX[:, 1:], MATRIX @ np.array([-1.0, 0.2, 0.1, 0.0]), rcond=None)[0]
    direction = step.parameters[1:] / np.abs(step.parameters).max()
    np.testing.assert_allclose(direction, expected / np.abs(expected).max(), atol=1e-10)
