"""Random errors of lines near a mode, from the closed form of its leakage and from coherence."""

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.estimation.windows import WINDOWS
from modallab.extraction.preprocessing.leakage import SinglePole, WindowLeakage
from modallab.extraction.preprocessing.leaked_lines import LeakedLines, leaked_lines, white_error_correlation
from modallab.extraction.preprocessing.random_errors import LineAccuracy, random_errors, relative_variance

FREQ = np.arange(95.0, 106.0)
X = (2 * np.pi * FREQ) ** 2
EIGENVALUE = np.array([(2 * np.pi * 100.3) ** 2 * (1 + 0.012j)])
CONSTANT = np.array([1.0, 0.4 - 0.1j, -0.7])
BACKGROUND = np.full((3, len(FREQ)), 1e-6 + 0j)
LEAKAGE = WindowLeakage.from_window(WINDOWS["hann"].samples(1024), "h1")
WHITE = white_error_correlation(LEAKAGE, FREQ, 1.0)
AVERAGES = 50.0


def lines() -> LeakedLines:
    response = SinglePole.of_mode(EIGENVALUE, CONSTANT, X, BACKGROUND)
    drive = SinglePole.of_mode(EIGENVALUE, CONSTANT[:1], X, BACKGROUND[:1])
    return leaked_lines(LEAKAGE, FREQ, 1.0, response, drive)


def leaked_variance() -> FloatArray:
    return np.diagonal(lines().errors.covariance, axis1=-2, axis2=-1).real / AVERAGES


def test_a_mode_and_its_background_are_the_inertance_of_their_receptance() -> None:
    pole = SinglePole.of_mode(EIGENVALUE, CONSTANT, X, BACKGROUND)
    inertance = pole.constant[:, None] / (pole.eigenvalue - X) + pole.residual
    receptance = CONSTANT[:, None] / (EIGENVALUE - X) + BACKGROUND
    np.testing.assert_allclose(inertance, -X * receptance, rtol=1e-9)  # cancellation beside the resonance


@pytest.mark.parametrize("common", [0.0, 0.4, 1.0])
def test_parts_add_up_to_the_variance_that_coherence_shows(common: float) -> None:
    # an equal excess in all FRFs, so that its common part is below none of them
    total = leaked_variance() + 1e-4
    errors = random_errors(lines(), WHITE, LineAccuracy(total, AVERAGES), common)
    diagonal = np.diagonal(errors.specific.covariance, axis1=-2, axis2=-1).real
    diagonal = diagonal + errors.common_leakage * AVERAGES * leaked_variance()
    if errors.common_noise is not None:
        diagonal = diagonal + np.diagonal(errors.common_noise.covariance).real
    np.testing.assert_allclose(diagonal, total, rtol=1e-9)  # rounding


def test_lines_keep_the_errors_of_leakage_where_coherence_shows_less() -> None:
    errors = random_errors(lines(), WHITE, LineAccuracy(np.zeros((3, len(FREQ))), AVERAGES))
    np.testing.assert_array_equal(errors.specific.covariance, lines().errors.scaled(1 / AVERAGES).covariance)


def test_noise_of_one_frf_is_not_common_to_all() -> None:
    noisy = leaked_variance()
    noisy[1] += 1.0
    errors = random_errors(lines(), WHITE, LineAccuracy(noisy, AVERAGES), 1.0)
    assert errors.common_noise is not None
    # the median of the excess of three FRFs, two of which have none beyond rounding
    assert np.abs(errors.common_noise.covariance).max() < 1e-12
    np.testing.assert_allclose(np.diagonal(errors.specific.covariance[1]).real, 1.0, rtol=1e-9)


def test_noise_ties_neighbouring_lines_as_the_window_does() -> None:
    total = leaked_variance() + 1e-4
    errors = random_errors(lines(), WHITE, LineAccuracy(total, AVERAGES)).specific
    noise = errors.covariance - lines().errors.scaled(1 / AVERAGES).covariance
    # 4/9 and 1/36 of the first and second neighbour, for a Hann window
    np.testing.assert_allclose(noise[0, 5, 5:8].real / 1e-4, [1, 4 / 9, 1 / 36], rtol=1e-6)


def test_lines_without_weight_or_response_have_no_determined_error() -> None:
    variance = relative_variance(np.array([0.0, 4.0, 4.0]), np.array([1.0, 0.0, 0.5j]))
    np.testing.assert_array_equal(variance, [0.0, 0.0, 1.0])
