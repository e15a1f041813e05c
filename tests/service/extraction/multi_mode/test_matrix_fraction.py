import numpy as np
import pytest

from modallab.extraction.multi_mode.matrix_fraction import fit_fractions, to_z_domain
from tests.synthetic import six_modes

ORDERS = np.array([20, 40])


def test_sums_over_the_lines_are_those_of_powers_of_z() -> None:
    case = six_modes(40, 0, upper=20.0)
    circle = to_z_domain(case.noisy[:, :, None], 1 / case.variance[:, :, None], 6)
    z = np.exp(2j * np.pi * np.arange(len(case.freq)) / circle.points)
    lags = np.arange(-6, 7)
    direct = circle.frf @ z[:, None] ** lags
    np.testing.assert_allclose(circle.sums(circle.frf, 6), direct, atol=1e-12 * np.abs(direct).max())


def test_the_arc_grows_with_the_order_and_never_closes() -> None:
    case = six_modes(40, 0)
    points = [
        to_z_domain(case.noisy[:, :, None], 1 / case.variance[:, :, None], order).points
        for order in (10, 40, 200)
    ]
    assert points[0] >= points[1] > points[2] > len(case.freq)


@pytest.mark.parametrize("told", [1.0, 4.0])
@pytest.mark.parametrize("own", [False, True])
def test_the_data_say_how_much_noise_there_is(told: float, own: bool) -> None:
    case = six_modes(40, 1)
    rng = np.random.default_rng(5)
    # weights of their own in every FRF, or alike in all
    factor = rng.uniform(0.5, 2, case.variance.shape) if own else np.ones(case.variance.shape)
    unit = (rng.standard_normal(factor.shape) + 1j * rng.standard_normal(factor.shape)) / np.sqrt(2)
    frf = case.exact + np.sqrt(case.variance * factor) * unit
    weight = 1 / (told * factor * case.variance)
    fractions = fit_fractions(to_z_domain(frf[:, :, None], weight[:, :, None], 40), ORDERS)
    # 12 FRFs of 1121 lines tell it to 1 %, and the least of 41 directions is some 15 % below the mean
    assert 0.75 < told * fractions.noise < 1.05


def test_the_lowest_coefficient_is_held_and_none_is_beyond_the_order() -> None:
    case = six_modes(40, 1)
    circle = to_z_domain(case.noisy[:, :, None], 1 / case.variance[:, :, None], 40)
    denominator = fit_fractions(circle, ORDERS).denominator
    assert denominator.shape == (2, 41, 1, 1)
    np.testing.assert_array_equal(denominator[:, 0, 0, 0], 1)
    np.testing.assert_array_equal(denominator[0, 21:], 0)
    assert np.abs(denominator[1, 21:]).max() > 0
