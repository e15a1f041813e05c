"""The smooth curve follows values line by line with fewer numbers, and states its error."""

import numpy as np

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
