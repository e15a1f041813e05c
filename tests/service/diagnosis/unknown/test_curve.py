"""The smooth curve follows values line by line with fewer numbers, and states its error."""

import numpy as np
import pytest

from modallab.diagnosis.unknown.curve import SmoothCurve

FREQ = np.linspace(5.0, 800.0, 400)
TRUE = 1e4 * (1 + 1j) * np.sqrt(FREQ / 800.0)


def _curve(seed: int) -> SmoothCurve:
    error = np.full(len(FREQ), 100.0)
    noise = np.random.default_rng(seed).standard_normal((2, len(FREQ)))
    return SmoothCurve.through(FREQ, TRUE + error * (noise[0] + 1j * noise[1]), error)


def test_a_curve_has_one_coefficient_for_ten_lines() -> None:
    assert len(_curve(0).sites) == 40
    assert _curve(0).n_parameters == 80


def test_its_stated_error_is_that_of_repeated_noise() -> None:
    sites = _curve(0).sites[5:-5]
    values = np.array([_curve(seed).at(sites) for seed in range(200)])
    scatter = np.concatenate([values.real.std(axis=0, ddof=1), values.imag.std(axis=0, ddof=1)])
    stated = np.tile(_curve(0).error[5:-5], 2)
    # a standard deviation of 200 draws is known to 5 %; the mean of 60 of them to less than 2 %
    assert abs((scatter / stated).mean() - 1) < 0.05


def test_beyond_its_ends_it_keeps_the_values_of_its_ends() -> None:
    curve = _curve(0)
    assert np.allclose(curve.at(np.array([0.0])), curve.at(FREQ[:1]))


@pytest.mark.parametrize("first", [3.245, 3.2175, 7.11])
def test_its_values_are_within_its_lines_whatever_the_rounding(first: float) -> None:
    """The mean of three times 3.245 Hz is below it by rounding, where no spline is defined."""
    freq = first + np.arange(40.0)
    curve = SmoothCurve.through(freq, np.ones(40, complex), np.ones(40))
    assert first <= curve.sites[0] == pytest.approx(first)
    assert pytest.approx(freq[-1]) == curve.sites[-1] <= freq[-1]
