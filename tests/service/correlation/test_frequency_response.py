import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.arrays import ComplexArray
from modallab.correlation.frequency_response import fdac, frac, ridge


def responses(seed: int, n_freq: int = 12) -> ComplexArray:
    rng = np.random.default_rng(seed)
    shape = (n_freq, 5, 2)
    values: ComplexArray = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    return values


@given(seed=st.integers(0, 1000), scale=st.complex_numbers(min_magnitude=1e-6, max_magnitude=1e6))
@settings(max_examples=50, deadline=None)
def test_both_stay_within_0_and_1_and_see_no_scale(seed: int, scale: complex) -> None:
    one, other = responses(seed), responses(seed + 1)
    for criterion in (frac, fdac):
        values = criterion(one, other)
        assert (values >= 0).all()
        assert (values <= 1).all()
        np.testing.assert_allclose(criterion(scale * one, other), values, rtol=1e-9, atol=1e-12)  # rounding
    np.testing.assert_allclose(frac(one, scale * one), 1.0, rtol=1e-12)
    np.testing.assert_allclose(np.einsum("iff->if", fdac(one, scale * one)), 1.0, rtol=1e-12)


def test_frac_is_one_number_an_frf_and_fdac_one_a_pair_of_lines() -> None:
    one, other = responses(1), responses(2, n_freq=7)
    assert frac(one, one).shape == (5, 2)
    assert fdac(one, other).shape == (2, 12, 7)


def test_a_factor_of_every_line_changes_frac_and_not_fdac() -> None:
    one = responses(3)
    tilted = one * np.linspace(1, 3, 12)[:, None, None] ** 2  # as inertance is tilted against receptance
    assert (frac(one, tilted) < 0.99).all()
    np.testing.assert_allclose(fdac(one, tilted), fdac(one, one), rtol=1e-9)


def test_zeros_are_like_nothing() -> None:
    one = responses(4)
    assert not frac(np.zeros_like(one), one).any()
    assert not fdac(one, np.zeros_like(one)).any()


def test_a_ridge_is_found_between_two_lines() -> None:
    step = 0.01
    grid = step * np.arange(200)
    for scale in (0.853, 1.0, 1.2345):
        away = grid[:, None] - grid - np.log(scale)
        values = np.exp(-((away / 0.03) ** 2))[None]
        found, at_best, at_one = ridge(values, step)
        assert found is not None
        assert at_best is not None
        assert np.isclose(found, scale, rtol=1e-3)  # a tenth of a step: the parabola through three means
        assert at_best > 0.97
        assert np.isclose(at_one, np.exp(-((np.log(scale) / 0.03) ** 2)))


def test_a_mean_that_only_rises_towards_the_end_is_no_ridge() -> None:
    grid = 0.01 * np.arange(200)
    rising = 1 / (1 + np.exp(-(grid[:, None] - grid)))[None]
    found, at_best, at_one = ridge(rising, 0.01)
    assert (found, at_best) == (None, None)
    assert np.isclose(at_one, 0.5)
