"""Zhang's second method."""

import numpy as np
import pytest

from modallab.updating.error_location.method import LOCATORS, LinearLocation, LinearProblem

RNG = np.random.default_rng(5)
SENSITIVITY = RNG.standard_normal((40, 12))


def run(difference: np.ndarray, threshold: float = 0.05) -> LinearLocation:
    problem = LinearProblem(SENSITIVITY, difference)
    return LOCATORS["zhang_subspace"](problem, threshold=threshold, jump=1e3)


def test_a_few_wrong_coefficients_are_found_with_their_size() -> None:
    wrong = np.zeros(12)
    wrong[[2, 7, 9]] = [0.5, -0.3, 0.2]
    found = run(SENSITIVITY @ wrong)
    np.testing.assert_allclose(found.change, wrong, atol=1e-12)  # linear and noise-free: exact
    assert found.suspected.nonzero()[0].tolist() == [2, 7, 9]
    assert found.rank == 3


def test_what_remains_is_what_least_squares_leave() -> None:
    difference = SENSITIVITY[:, 3] + 0.5 * RNG.standard_normal(40)
    found = run(difference, threshold=0.0)
    assert (np.diff(found.remaining) < 0).all()
    left = difference - SENSITIVITY @ found.change
    assert found.remaining[-1] == pytest.approx(np.linalg.norm(left) / np.linalg.norm(difference))
    # no other single coefficient would have left less than the first one chosen
    alone = [
        np.linalg.norm(difference - c * (c @ difference) / (c @ c)) / np.linalg.norm(difference)
        for c in SENSITIVITY.T
    ]
    assert found.remaining[0] == pytest.approx(min(alone))


def test_no_difference_gives_no_suspect() -> None:
    found = run(np.zeros(40))
    assert not found.suspected.any()
    assert found.rank == 0
    assert found.remaining.size == 0
