"""Two modes where one is fitted are told by what the fit leaves, and by a second peak."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract
from modallab.extraction.options import DistantLinesOptions, ExtractionOptions
from modallab.extraction.single_mode.method import EXTRACTION_METHODS

EXACT = [kind for kind in sorted(EXTRACTION_METHODS) if EXTRACTION_METHODS[kind].exact]
FREQ = np.arange(1.0, 200.0, 0.5)
LOSS = 0.01
SHAPES = np.array([[1.0, 1.0, 1.0], [1.0, 0.6, -0.5]])


def frfs(*frequencies: float) -> FrfSet:
    """Three receptances of modes at these frequencies."""
    eigenvalue = (2 * np.pi * np.array(frequencies)) ** 2 * (1 + 1j * LOSS)
    shapes = SHAPES[: len(frequencies)]
    values: ComplexArray = 1 / (eigenvalue - (2 * np.pi * FREQ[:, None]) ** 2) @ (shapes * shapes[:, :1])
    outputs = tuple(Dof(node, "Y") for node in (1, 2, 3))
    return FrfSet(FREQ, values[:, :, None], outputs, outputs[:1], FrfKind.RECEPTANCE)


def modes_of(frf: FrfSet, method: str, options: ExtractionOptions | None = None) -> ModalModel:
    chosen = options or ExtractionOptions()
    return extract(frf, coherence=None, averages=100.0, method=method, bands=[(40.0, 65.0)], options=chosen)


@pytest.mark.parametrize("method", EXACT)
def test_a_pair_fitted_as_one_mode_is_flagged(method: str) -> None:
    model = modes_of(frfs(50.3, 51.1), method)  # 1.6 bandwidths apart: one peak in most FRFs
    assert any(flag.startswith("misfit") for flag in model.modes[0].flags)


@pytest.mark.parametrize("method", EXACT)
def test_a_mode_by_itself_is_not_flagged_with_five_per_cent_of_noise_either(method: str) -> None:
    frf = frfs(50.3)
    rng = np.random.default_rng(1)
    noise = rng.normal(size=(2, *frf.values.shape)) * 0.05 / np.sqrt(2)
    noisy = FrfSet(
        FREQ, frf.values * (1 + noise[0] + 1j * noise[1]), frf.outputs, frf.inputs, FrfKind.RECEPTANCE
    )
    for one in (frf, noisy):
        assert modes_of(one, method).modes[0].flags == ()


@pytest.mark.parametrize("method", EXACT)
def test_a_second_peak_in_a_given_band_is_flagged_with_its_frequency(method: str) -> None:
    (mode,) = modes_of(frfs(50.3, 57.1), method).modes
    (flag,) = [flag for flag in mode.flags if flag.startswith("further peak")]
    other = 50.5 if mode.frequency > 55 else 57.0  # the line nearest, or next to it
    assert f"{other:g} Hz" in flag or f"{other - 0.5:g} Hz" in flag


def test_lines_that_were_left_out_say_nothing_of_a_misfit() -> None:
    frf = frfs(50.3)
    values = frf.values.copy()
    values[97:101] *= np.array([1.2, 1.3, 1.4, 1.1])[:, None, None]  # 49.5 to 51 Hz
    spoilt = FrfSet(FREQ, values, frf.outputs, frf.inputs, frf.kind)
    (mode,) = modes_of(spoilt, "dobson", DistantLinesOptions(leave_out=4)).modes
    assert mode.flags == ()
