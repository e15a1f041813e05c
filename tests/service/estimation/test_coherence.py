"""Coherence and the random errors that follow from it."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from modallab.core.numerics import COHERENCE_ROUNDING
from modallab.estimation.coherence import coherence, coherence_error, frf_error, incoherent_ratio
from modallab.estimation.spectra import CrossSpectra

ratios = st.floats(0, 1e3)


def noisy(r_i: float, r_o: float, h: complex = 2 - 1j) -> CrossSpectra:
    return CrossSpectra(
        np.array([10.0]),
        np.full((1, 1, 1, 1), 3 * (1 + r_i) + 0j),
        np.full((1, 1, 1, 1), 3 * h),
        np.full((1, 1, 1), 3 * abs(h) ** 2 * (1 + r_o)),
        10,
    )


@given(ratios, ratios)
def test_noise_on_both_sides_divides_coherence_twice(r_i: float, r_o: float) -> None:
    # 1992 thesis, eq. [5.8]; rounding
    assert np.isclose(coherence(noisy(r_i, r_o)), 1 / ((1 + r_i) * (1 + r_o)), rtol=1e-13)


def test_a_channel_that_hears_nothing_has_no_coherence() -> None:
    silent = CrossSpectra(
        np.array([10.0]),
        np.ones((1, 1, 1, 1), complex),
        np.zeros((1, 1, 1, 2), complex),
        np.zeros((1, 1, 2)),
        9,
    )
    np.testing.assert_array_equal(coherence(silent), 0.0)


def test_random_errors_have_their_printed_size() -> None:
    # 1992 thesis, eq. [5.16] and [5.18]: coherence 0.8, 50 averages
    assert np.isclose(frf_error(np.array(0.8), 50), np.sqrt(0.2 / 80), rtol=1e-14)
    assert np.isclose(coherence_error(np.array(0.8), 50), np.sqrt(2) * 0.2 / np.sqrt(40), rtol=1e-14)


@given(st.floats(0.01, 1), st.floats(2, 1e4))
def test_random_errors_fall_with_coherence_and_with_averages(g2: float, averages: float) -> None:
    for error in (frf_error, coherence_error):
        here = error(np.array(g2), averages)
        assert here >= error(np.array(min(1.0, 1.1 * g2)), averages)
        assert here >= error(np.array(g2), 2 * averages)
    assert frf_error(np.array(1.0), averages) == coherence_error(np.array(1.0), averages) == 0


def test_no_coherence_is_a_huge_error_and_not_a_fault() -> None:
    assert frf_error(np.array(0.0), 100) > 1e100


def test_incoherent_over_coherent_power_follows_from_the_coherence() -> None:
    ratio = incoherent_ratio(np.array([0.5, 0.8, 1.0]))
    # what counts as rounding is added; beyond it the quotient's own rounding
    np.testing.assert_allclose(ratio - COHERENCE_ROUNDING, [1.0, 0.25, 0.0], rtol=1e-12, atol=1e-16)
