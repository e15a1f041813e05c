"""Modes beside what is no constant: rigid bodies below, a mode above."""

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.extraction.options import Damping
from modallab.extraction.single_mode.damping_models import DAMPING_MODELS
from modallab.extraction.single_mode.fit_data import FitData
from modallab.extraction.single_mode.fitting import fit_all, fit_once
from modallab.extraction.single_mode.method import EXTRACTION_METHODS
from modallab.extraction.single_mode.residual_bias import residual_shift

METHOD, LAW = EXTRACTION_METHODS["dobson"], DAMPING_MODELS[Damping.STRUCTURAL]
FREQUENCY = np.array([40.0, 80.0, 130.0, 190.0])
EIGENVALUE = (2 * np.pi * FREQUENCY) ** 2 * (1 + 1j * 4.0 / FREQUENCY)  # four lines wide
ABOVE = (2 * np.pi * 260.0) ** 2


def read(n_modes: int, *, rest: bool) -> tuple[ComplexArray, ComplexArray]:
    """Return modal constants as fitted, and as they are without a rest that is no constant."""
    freq = np.round(FREQUENCY[:n_modes, None, None]) + np.arange(-8.0, 9.0)
    x = (2 * np.pi * freq) ** 2
    values = (1 / (EIGENVALUE[:n_modes] - x[..., None])).sum(axis=-1)
    if rest:
        values = values - 0.5 / x + 1 / (ABOVE - x)
    data = FitData(freq, values, np.full(freq.shape, 1e20), 1.0, None, None)
    settled = fit_all(METHOD, LAW, data)
    now = fit_once(METHOD, LAW, data, settled.cleaned, settled.inertance)
    moved = residual_shift(METHOD, LAW, data, settled, now)
    constant = now.table.modal_constant
    return constant[:, 0], constant[:, 0] + moved[:, 0, 2] + 1j * moved[:, 0, 3]


def test_taking_a_smooth_rest_off_moves_modes_most_of_the_way_to_the_truth() -> None:
    before, after = read(4, rest=True)
    off, left = np.abs(before - 1), np.abs(after - 1)
    assert off.min() > 1e-3
    # two terms are not the whole rest: that of a mode at 260 Hz bends more at 190 Hz than they do
    assert (left[:3] < 0.5 * off[:3]).all()
    assert left[3] < off[3]


def test_modes_with_no_rest_but_a_constant_stay() -> None:
    before, after = read(4, rest=False)
    np.testing.assert_allclose(after, before, atol=1e-6)  # what three rounds of neighbours have left


def test_two_modes_tell_nothing_of_a_rest() -> None:
    before, after = read(2, rest=True)
    np.testing.assert_array_equal(after, before)
