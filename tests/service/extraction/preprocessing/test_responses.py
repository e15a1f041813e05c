"""Tests of FRFs in the form that extraction uses."""

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.extraction.extract import extract
from modallab.extraction.preprocessing.line_noise import has_coherence, line_weights
from modallab.extraction.preprocessing.responses import responses_of

FREQ = np.linspace(0.0, 60.0, 961)  # Hz
FREQUENCY = np.array([12.0, 25.0, 41.0])
DOFS = tuple(Dof(n + 1, "Z") for n in range(8))
AVERAGES = 5
NOISE = 0.01  # of the median of an FRF


def quiet_test(digits: int) -> tuple[FrfSet, FloatArray]:
    """Return FRFs with little noise, and their coherence as a file of few digits has it."""
    rng = np.random.default_rng(3)
    shapes = rng.standard_normal((len(FREQUENCY), len(DOFS)))
    square = (2 * np.pi * FREQ[:, None]) ** 2
    exact = -square / ((2 * np.pi * FREQUENCY) ** 2 * (1 + 0.02j) - square) @ (shapes * shapes[:, :1])
    level = NOISE * np.median(np.abs(exact), axis=0)
    parts = rng.standard_normal((2, AVERAGES, *exact.shape))
    values = exact + level * (parts[0] + 1j * parts[1]).mean(axis=0) / np.sqrt(2)
    freedom = AVERAGES - 1
    power = level**2 * rng.gamma(freedom, 1 / AVERAGES, exact.shape)
    coherence = 1 / (1 + power / np.maximum(np.abs(values) ** 2, 1e-30))
    frf = FrfSet(FREQ, values[:, :, None], DOFS, DOFS[:1], FrfKind.INERTANCE)
    return frf, np.round(coherence, digits)


def test_a_line_whose_coherence_is_rounded_to_one_counts_little_more_than_the_best_of_the_others() -> None:
    frf, coherence = quiet_test(4)
    responses = responses_of(frf, coherence, AVERAGES)
    weight = line_weights(responses) * np.abs(responses.receptance) ** 2  # one over relative variances
    exact = coherence[1:] == 1
    assert exact.any()
    # half of the least that is not rounded to zero
    np.testing.assert_allclose(weight[exact], 2 * weight[~exact].max(), rtol=1e-3)


@pytest.mark.parametrize("bands", [None, [(8.0, 55.0)]])
def test_modes_are_found_where_a_file_rounds_much_of_the_coherence_to_one(
    bands: list[tuple[float, float]] | None,
) -> None:
    frf, coherence = quiet_test(4)
    assert (coherence == 1).mean() > 0.3
    model = extract(frf, coherence=coherence, averages=AVERAGES, method="lscf", bands=bands)
    np.testing.assert_allclose(model.frequencies, FREQUENCY, rtol=1e-4)  # of the noise, 1e-5
    np.testing.assert_allclose(model.loss_factors, 0.02, rtol=0.01)  # the same


def test_a_coherence_of_one_everywhere_is_none() -> None:
    frf, coherence = quiet_test(4)
    assert not has_coherence(responses_of(frf, np.ones_like(coherence), AVERAGES))
