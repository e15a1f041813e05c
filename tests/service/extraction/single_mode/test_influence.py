"""How fits follow their lines, against the fits of lines that are a little wrong."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.leaked_lines import LineErrors
from modallab.extraction.single_mode.damping_models import DAMPING_MODELS
from modallab.extraction.single_mode.fit_data import FitData
from modallab.extraction.single_mode.fitting import fit_once
from modallab.extraction.single_mode.influence import influence
from modallab.extraction.single_mode.method import EXTRACTION_METHODS

EXACT = [kind for kind in sorted(EXTRACTION_METHODS) if EXTRACTION_METHODS[kind].exact]
FREQ = np.arange(94.0, 107.0)
EIGENVALUE = (2 * np.pi * 100.3) ** 2 * (1 + 0.02j)  # two lines wide
RECEPTANCE: ComplexArray = np.array([[1.0], [0.3 + 0.1j]]) / (EIGENVALUE - (2 * np.pi * FREQ) ** 2) + 1e-6
NOISE = 1e-3
RECEPTANCE_ALONE = np.array([False])


def data(receptance: ComplexArray) -> FitData:
    """Return one mode in two FRFs."""
    weight = 1 / (NOISE * np.abs(RECEPTANCE)) ** 2
    lines = np.broadcast_to(FREQ, receptance.shape)
    return FitData(lines[None], receptance[None], weight[None], 1.0, None, None)


def parts(method: str, receptance: ComplexArray) -> FloatArray:
    """Return real and imaginary part of eigenvalue and modal constant, (n_frf, 4)."""
    lines = data(receptance)
    fits = fit_once(
        EXTRACTION_METHODS[method],
        DAMPING_MODELS[Damping.STRUCTURAL],
        lines,
        lines.receptance,
        RECEPTANCE_ALONE,
    )
    pole, constant = fits.eigenvalue[0], fits.table.modal_constant[0]
    return np.stack([pole.real, pole.imag, constant.real, constant.imag], axis=-1)


def followed(method: str) -> ComplexArray:
    law, lines = DAMPING_MODELS[Damping.STRUCTURAL], data(RECEPTANCE)
    now = fit_once(EXTRACTION_METHODS[method], law, lines, lines.receptance, RECEPTANCE_ALONE)
    return influence(EXTRACTION_METHODS[method], law, lines, now, 0, slice(0, 2))


@pytest.mark.parametrize("method", EXACT)
def test_small_errors_of_lines_move_a_mode_as_its_influence_says(method: str) -> None:
    rng = np.random.default_rng(2)
    error = 1e-5 * np.abs(RECEPTANCE) * (rng.standard_normal((2, 13)) + 1j * rng.standard_normal((2, 13)))
    expected = (followed(method) @ error[..., None])[..., 0].real
    moved = parts(method, RECEPTANCE + error) - parts(method, RECEPTANCE)
    # errors of 1e-5 bend the answer by as much of itself, some lines more; a percent is far beyond that
    np.testing.assert_allclose(moved, expected, rtol=0.01, atol=1e-3 * np.abs(expected).max(axis=0).min())


def test_influence_on_independent_errors_gives_the_errors_that_a_weighted_fit_states() -> None:
    method = "linear_fit"  # whose weights are those of least squares
    lines = data(RECEPTANCE)
    fits = fit_once(
        EXTRACTION_METHODS[method],
        DAMPING_MODELS[Damping.STRUCTURAL],
        lines,
        lines.receptance,
        RECEPTANCE_ALONE,
    )
    each = np.zeros((2, 13, 13), complex)
    each[:, np.arange(13), np.arange(13)] = (NOISE * np.abs(RECEPTANCE)) ** 2
    covariance = LineErrors(each, np.zeros_like(each)).propagate(followed(method))
    size = np.sqrt(covariance[:, 2, 2])
    # linearised both times: what is left is the step of differences
    np.testing.assert_allclose(size, fits.table.modal_constant_error[0], rtol=1e-3)
    np.testing.assert_allclose(
        np.sqrt(covariance[:, 0, 0]) / (8 * np.pi**2 * 100.3), fits.table.frequency_error[0], rtol=1e-3
    )
