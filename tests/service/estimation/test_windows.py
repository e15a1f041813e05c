"""Windows against what is printed of them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from modallab.estimation.windows import WINDOWS


def test_the_hanning_line_shape_has_its_printed_values() -> None:
    # 1992 thesis, eq. [5.13], times the line spacing 1/T: W(0) = 2/3, W(1) = 1/6, W(2) = 0
    np.testing.assert_allclose(
        WINDOWS["hann"].line_shape(np.array([0.0, 1.0, -1.0, 2.0])), [2 / 3, 1 / 6, 1 / 6, 0], atol=1e-16
    )


@given(st.floats(-30, 30).filter(lambda x: min(abs(x), abs(abs(x) - 1)) > 1e-3))
def test_the_hanning_line_shape_follows_its_closed_form(x: float) -> None:
    # 1992 thesis, eq. [5.12]; 1 - x^2 loses three digits at the nearest points drawn, and where the
    # shape is zero its root is left with the rounding of sines, 1e-17
    closed = 2 / 3 * (np.sin(np.pi * x) / (np.pi * x * (1 - x**2))) ** 2
    assert np.isclose(WINDOWS["hann"].line_shape(np.array(x)), closed, rtol=1e-9, atol=1e-20)


def test_a_rectangular_window_shows_a_periodic_signal_its_own_line_alone() -> None:
    shape = WINDOWS["rectangular"].line_shape(np.arange(-4.0, 5.0))
    np.testing.assert_allclose(shape, np.eye(9)[4], atol=1e-30)  # sin(pi k) is not quite zero


def test_a_flat_top_window_shows_a_sine_between_lines_at_its_own_height() -> None:
    window = WINDOWS["flat_top"]
    on_line, between = window.line_shape(np.array([0.0, 0.5]))
    assert np.isclose(between, on_line, rtol=2 * 0.0012)  # 0.01 dB of scalloping, in power
