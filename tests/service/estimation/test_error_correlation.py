"""Tests of the correlation of the errors of neighbouring lines."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.estimation.error_correlation import ErrorCorrelation
from modallab.estimation.windows import WINDOWS

EXPONENTIAL = WINDOWS["exponential"]


@pytest.mark.parametrize("window", ["rectangular", "hann", "exponential"])
def test_the_correlation_of_lines_is_that_of_windowed_white_noise(window: str) -> None:
    n, n_records = 256, 20_000
    noise = np.random.default_rng(0).standard_normal((n_records, n)) * WINDOWS[window].samples(n)
    lines = np.fft.rfft(noise)[:, 40:45]
    measured = lines.T @ lines.conj() / n_records
    measured /= measured[0, 0].real
    # three standard errors of an entry, 1/sqrt(records)
    np.testing.assert_allclose(ErrorCorrelation(WINDOWS[window]).matrix(5), measured, atol=0.03)


def test_a_force_later_in_the_record_turns_the_phase_from_line_to_line() -> None:
    plain, late = ErrorCorrelation(EXPONENTIAL).matrix(4), ErrorCorrelation(EXPONENTIAL, delay=0.1).matrix(4)
    turned = np.exp(2j * np.pi * 0.1 * np.arange(4))
    np.testing.assert_allclose(late, turned[:, None] * plain * turned.conj(), atol=1e-12)  # rounding


def test_whitening_makes_lines_independent() -> None:
    correlation = ErrorCorrelation(replace(EXPONENTIAL, end=1e-3), delay=0.05)
    whitening = correlation.whitening(17)
    white = whitening @ correlation.matrix(17) @ whitening.conj().T
    np.testing.assert_allclose(white, np.eye(17), atol=1e-8)  # rounding times the condition number
