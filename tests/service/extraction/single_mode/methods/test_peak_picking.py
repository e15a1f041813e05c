import numpy as np
import pytest

from modallab.core.errors import NoModeInBandError
from modallab.extraction.single_mode.method import EXTRACTION_METHODS, ModeFit, fit_mode

PEAK = EXTRACTION_METHODS["peak_picking"]


def test_a_peak_drawn_with_many_lines_gives_its_mode() -> None:
    mode = ModeFit(100.0, 0.02, 1 + 0.1j)
    freq = np.linspace(94, 106, 1201)  # 200 lines in the bandwidth, one of them on the resonance
    found = fit_mode(PEAK, freq, mode.response(freq))
    assert found.frequency == pytest.approx(100.0, rel=1e-12)
    # straight lines between lines 1/100 of the half bandwidth apart
    assert found.loss_factor == pytest.approx(0.02, rel=1e-4)
    assert found.modal_constant == pytest.approx(1 + 0.1j, rel=1e-4)


@pytest.mark.parametrize("bandwidth", [3.0, 6.0])
def test_the_bias_is_as_large_as_it_says(bandwidth: float) -> None:
    position = (np.arange(40) + 0.5) / 40 - 0.5
    modes = [ModeFit(100 + p, bandwidth / (100 + p), 1.0) for p in position]
    freq = np.tile(np.arange(80.0, 121.0), (40, 1))
    frf = np.array([mode.response(freq[0]) for mode in modes])
    fits = PEAK(freq, frf, np.ones(frf.shape))
    off = fits.frequency / (100 + position) - 1
    assert 100 * np.sqrt((off**2).mean()) == pytest.approx(fits.quality["frequency_bias"].mean(), rel=0.02)
    # too wide, and more so between lines; the chords of the flanks add the rest
    wide = fits.loss_factor / [mode.loss_factor for mode in modes] - 1
    said = fits.quality["loss_factor_bias"].mean()
    assert 0.5 * said < 100 * np.sqrt((wide**2).mean()) < 2 * said
    assert wide.min() > -0.01


def test_a_peak_cut_on_one_side_is_taken_as_symmetric() -> None:
    mode = ModeFit(100.0, 0.05, 1.0)
    freq = np.arange(98.5, 110.0, 0.5)  # half power lies at 97.5 Hz
    found = fit_mode(PEAK, freq, mode.response(freq))
    assert found.loss_factor == pytest.approx(0.05, rel=0.03)  # mirrored in omega^2, chords of 0.5 Hz


def test_a_hump_that_never_falls_to_half_has_no_width() -> None:
    freq = np.arange(99.0, 102.0, 0.5)
    with pytest.raises(NoModeInBandError):
        fit_mode(PEAK, freq, ModeFit(100.0, 0.05, 1.0).response(freq))
