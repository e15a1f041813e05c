import re

import numpy as np
import pytest

from modallab.diagnosis.reporting import svg


def test_a_thinned_curve_keeps_its_highest_and_its_lowest_point() -> None:
    x = np.linspace(0, 1, 10_001)
    one, other = np.sin(40 * x), np.cos(300 * x)
    one[1234], other[8765] = 9.0, -9.0
    few, (first, second) = svg.thinned(x, [one, other])
    # both extremes of both curves in each of 350 stretches
    assert len(few) == len(first) == len(second) <= 1400 + 28
    assert (first.max(), first.min()) == (one.max(), one.min())
    assert (second.max(), second.min()) == (other.max(), other.min())
    np.testing.assert_array_equal(first, np.interp(few, x, one))


def test_a_short_curve_is_left_as_it_is() -> None:
    x = np.linspace(0, 1, 401)
    few, (same,) = svg.thinned(x, [x**2])
    assert few is x
    np.testing.assert_array_equal(same, x**2)


@pytest.mark.parametrize(
    ("lower", "upper", "names"),
    [
        (0.0, 800.0, ["0", "200", "400", "600", "800"]),
        (-40.0, 25.0, ["-40", "-20", "0", "20"]),
        (-0.3, 0.1, ["-0.3", "-0.2", "-0.1", "0", "0.1"]),
    ],
)
def test_ticks_are_round_numbers_within_the_limits(lower: float, upper: float, names: list[str]) -> None:
    assert [text for _, text in svg.linear(lower, upper, "", n_ticks=5).ticks] == names


def test_decades_are_written_as_numbers_and_beyond_as_powers() -> None:
    assert [text for _, text in svg.decades(-1.2, 5.0, "").ticks] == [
        "0.01",
        "0.1",
        "1",
        "10",
        "100",
        "1000",
        "10000",
        "10⁵",
    ]


def test_a_curve_breaks_where_there_is_no_number() -> None:
    axis = svg.linear(0.0, 4.0, "")
    x = np.arange(5.0)
    drawn = svg.line(svg.Frame(axis, axis), x, np.array([1.0, 2.0, np.nan, 3.0, 4.0]), "measured")
    assert len(re.findall("M", drawn)) == 2
    assert "nan" not in drawn


def test_up_is_more() -> None:
    axis = svg.linear(0.0, 1.0, "")
    frame = svg.Frame(axis, axis)
    assert frame.down(np.array(1.0)) < frame.down(np.array(0.0))
    assert frame.across(np.array(1.0)) > frame.across(np.array(0.0))
