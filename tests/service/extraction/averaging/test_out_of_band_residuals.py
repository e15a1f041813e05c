import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.averaging.out_of_band_residuals import fit_out_of_band, out_of_band_columns

FREQ: FloatArray = np.linspace(2.0, 100.0, 99)
BEYOND: ComplexArray = np.asarray((2 * np.pi * np.array([1.0, 120.0])) ** 2 * (1 + 0.02j), complex)
CONSTANTS = np.array([[0.5, 0.7], [2e-6, -1e-6 + 1e-7j], [0.1, 0.2j], [1.0, -2.0]])


def test_poles_beyond_are_told_from_mass_and_constant() -> None:
    rest = out_of_band_columns(FREQ, BEYOND) @ CONSTANTS
    found = fit_out_of_band(FREQ, rest, np.abs(rest) ** 2, BEYOND)
    # a pole at 1 Hz is a mass line but for a quarter at 2 Hz: rounding is larger by the square of that
    np.testing.assert_allclose(found, CONSTANTS, rtol=1e-6)


def test_lines_that_do_not_count_do_not() -> None:
    rest = out_of_band_columns(FREQ, BEYOND) @ CONSTANTS
    variance = np.abs(rest) ** 2
    rest[40], variance[40] = 1.0, np.inf
    np.testing.assert_allclose(fit_out_of_band(FREQ, rest, variance, BEYOND), CONSTANTS, rtol=1e-6)
    np.testing.assert_array_equal(fit_out_of_band(FREQ, rest, np.full(rest.shape, np.inf), BEYOND), 0)


@pytest.mark.parametrize("error", [1e-14, 1e-6])
def test_a_mode_that_was_left_out_is_not_paid_for_elsewhere(error: float) -> None:
    columns = out_of_band_columns(FREQ, BEYOND[:0])
    gap = (2 * np.pi * 50.0) ** 2 * (1 + 0.01j) - (2 * np.pi * FREQ[:, None]) ** 2
    rest = columns @ CONSTANTS[:2, :1] + 1e-2 / gap
    # random error is said to be least where the missed mode is strong
    variance = error * np.abs(rest) ** 2 * np.abs(FREQ[:, None] - 55.5)
    found = fit_out_of_band(FREQ, rest, variance, BEYOND[:0])
    mobility = FREQ[:, None] * columns
    best = np.linalg.lstsq(mobility, FREQ[:, None] * rest)[0]
    left, least = (np.sum(np.abs(FREQ[:, None] * rest - mobility @ made) ** 2) for made in (found, best))
    # by the random error alone it would be seven times as much
    assert left < 1.1 * least


def test_a_pole_that_is_held_above_the_range_is_no_resonance_where_frfs_go_on() -> None:
    freq = np.arange(1.0, 301.0)
    held = (2 * np.pi * 150.0) ** 2  # of a range up to 100 Hz
    column = out_of_band_columns(freq, np.array([held, held * (1 + 0.01j)]))[:, 2]
    inside = freq <= 100
    np.testing.assert_allclose(column[inside], 1 / (held - (2 * np.pi * freq[inside]) ** 2))
    assert np.isfinite(column).all()
    assert np.abs(column).max() * held < 2.1
