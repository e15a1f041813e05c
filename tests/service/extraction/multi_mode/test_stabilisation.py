import numpy as np
import pytest

from modallab.extraction.multi_mode.stabilisation import StabilisationTolerances, stabilise
from tests.service.extraction.charts import SPACING, chart


def level(after: tuple[float, float], before: tuple[float, float] = (100.0, 0.02)) -> int:
    """Return how stable a pole of order 5 is beside one of order 4; frequency Hz, loss factor."""
    return int(stabilise(chart([(4, *before), (5, *after)]))[1])


@pytest.mark.parametrize(
    ("after", "stable"),
    [
        ((100.0, 0.02), 3),
        ((100.39, 0.02), 3),  # a fifth of its bandwidth of 2 Hz
        ((100.41, 0.02), 0),
        ((100.0, 0.0209), 3),
        ((100.0, 0.0212), 1),  # five percent of 0.02
        ((100.3, 0.03), 1),
    ],
)
def test_a_pole_is_stable_as_far_as_it_agrees(after: tuple[float, float], stable: int) -> None:
    assert level(after) == stable


def test_a_pole_of_another_shape_is_stable_in_frequency_and_damping_only() -> None:
    vectors = np.array([[1, 0, 0], [1, 1, 0]], complex)
    assert stabilise(chart([(4, 100.0, 0.02), (5, 100.0, 0.02)], vectors)).tolist() == [0, 2]


def test_the_scale_of_a_shape_does_not_matter() -> None:
    vectors = np.array([[1, 2j, 3], [-2j, 4, -6j]], complex)
    assert stabilise(chart([(4, 100.0, 0.02), (5, 100.0, 0.02)], vectors)).tolist() == [0, 3]


def test_of_a_resonance_much_narrower_than_a_line_parts_of_the_line_are_allowed() -> None:
    narrow = (100.0, 1e-4)  # 0.01 Hz wide
    assert level((100.0 + 0.09 * SPACING, 1e-4), narrow) == 3
    assert level((100.0 + 0.11 * SPACING, 1e-4), narrow) == 0
    # half as wide again, by a hundredth of a line
    assert level((100.0, 1.5e-4), narrow) == 3


def test_a_broad_pole_must_agree_to_one_percent_all_the_same() -> None:
    broad = (100.0, 0.3)  # 30 Hz wide
    assert level((100.9, 0.3), broad) == 3
    assert level((101.1, 0.3), broad) == 0


def test_each_order_is_held_against_the_one_before_it_in_the_chart() -> None:
    poles = chart([(4, 100.0, 0.02), (6, 100.0, 0.02), (6, 50.0, 0.02), (9, 50.0, 0.02), (9, 100.0, 0.02)])
    assert stabilise(poles).tolist() == [0, 3, 0, 3, 3]


def test_a_pole_that_the_order_before_did_not_have_is_new() -> None:
    poles = chart([(4, 100.0, 0.02), (6, 100.0, 0.02)], orders=[4, 5, 6])
    assert stabilise(poles).tolist() == [0, 0]


def test_tolerances_are_the_users_to_choose() -> None:
    poles = chart([(4, 100.0, 0.02), (5, 100.0, 0.03)])
    assert stabilise(poles, StabilisationTolerances(loss_factor=0.6)).tolist() == [0, 3]


def test_an_empty_chart_has_no_levels() -> None:
    assert stabilise(chart([])).shape == (0,)
