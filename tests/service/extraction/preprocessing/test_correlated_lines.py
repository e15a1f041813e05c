"""Tests of sums over lines whose errors are correlated."""

import numpy as np
import pytest

from modallab.estimation.error_correlation import ErrorCorrelation
from modallab.estimation.windows import WINDOWS
from modallab.extraction.preprocessing.correlated_lines import CorrelatedLines

LATE = ErrorCorrelation(WINDOWS["exponential"], delay=0.05)


@pytest.mark.parametrize("correlation", [LATE, ErrorCorrelation(WINDOWS["hann"], random_force=True)])
def test_sums_over_lines_have_the_covariance_of_the_window(correlation: ErrorCorrelation) -> None:
    rng = np.random.default_rng(0)
    freq = np.delete(np.arange(100.0, 160.0, 0.5), [7, 8, 40])  # lines that are left out keep their distance
    values = rng.standard_normal((3, len(freq))) + 1j * rng.standard_normal((3, len(freq)))
    independent = CorrelatedLines.of(freq, correlation).independent(values)
    place = np.rint((freq - freq[0]) / 0.5).astype(int)
    exact = values.conj() @ correlation.matrix(place[-1] + 1)[np.ix_(place, place)] @ values.T
    found = independent.conj() @ independent.T
    # lines at both ends are correlated by up to 2 % as if they were 64 lines apart; the window has 192
    # samples instead of 4096, and the blow lies on one of them
    np.testing.assert_allclose(found, exact, atol=0.04 * np.abs(exact).max())


def test_a_rectangular_window_leaves_lines_independent() -> None:
    values = np.eye(50, dtype=complex)
    lines = CorrelatedLines.of(np.arange(50.0), ErrorCorrelation(WINDOWS["rectangular"]))
    independent = lines.independent(values)
    np.testing.assert_allclose(independent.conj() @ independent.T, np.eye(50), atol=1e-12)  # rounding
    assert lines.squared_correlation == pytest.approx(1.0, abs=1e-12)  # rounding
