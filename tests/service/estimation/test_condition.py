"""How well forces can be told apart."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.estimation.condition import input_condition
from modallab.estimation.spectra import CrossSpectra


def spectra(ff: ComplexArray) -> CrossSpectra:
    n = len(ff)
    return CrossSpectra(
        np.array([1.0]), ff[None, None], np.zeros((1, 1, n, 1), complex), np.ones((1, 1, 1)), 10
    )


@pytest.mark.parametrize("coherence", [0.0, 0.5, 0.99])
def test_of_two_equal_forces_it_is_that_of_their_coherence(coherence: float) -> None:
    tied = np.sqrt(coherence) * np.exp(0.7j)
    found = input_condition(spectra(np.array([[3, 3 * tied], [3 * np.conj(tied), 3]], complex)))
    # eigenvalues 1 +- gamma
    np.testing.assert_allclose(found, (1 + abs(tied)) / (1 - abs(tied)), rtol=1e-12)  # rounding


def test_of_unlike_forces_it_is_their_ratio_and_of_one_it_is_one() -> None:
    np.testing.assert_allclose(input_condition(spectra(np.diag([1.0, 1e4, 10.0]).astype(complex))), 1e4)
    np.testing.assert_allclose(input_condition(spectra(np.array([[7.0 + 0j]]))), 1.0)
    np.testing.assert_allclose(input_condition(spectra(np.zeros((2, 2), complex))), 1.0)
