"""Mains hum: sines that nothing explains."""

import numpy as np
import pytest

from modallab.core.place import Channels
from modallab.core.progress import silent
from modallab.effects.mains_hum import MainsHum
from modallab.estimation.coherence import coherence
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.acquisition import samples_of
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.sampled import sampled_spectra
from tests.rigs import beam_system, dofs, rig

SETTINGS = {"n_lines": 161, "averages": 200}  # 5 Hz a line
SPACING = 5.0


def added(hum: MainsHum, window: str) -> tuple[CrossSpectra, CrossSpectra]:
    """Expected spectra without and with the hum."""
    setup = rig(1, 7, analyser={**SETTINGS, "window": window})
    return expected_spectra(chain(beam_system(), setup)), expected_spectra(chain(beam_system(), setup, [hum]))


def own_transform(frequency: float, window: np.ndarray, offset: float, n_phases: int = 64) -> np.ndarray:
    """One-sided density of a sine of rms 1 with 3rd, 5th and 7th harmonics: the mean of its periodograms."""
    n = len(window)
    rate = n * SPACING
    t = np.arange(n) / rate
    total = np.zeros(161)
    for order in (1, 3, 5, 7):
        # The mean over all phases of a sine is that over equally spaced ones: exact for a square of it.
        for phase in 2 * np.pi * np.arange(n_phases) / n_phases + offset:
            sine = np.sqrt(2) / order * np.sin(2 * np.pi * order * frequency * t + phase)
            total += np.abs(np.fft.rfft(window * sine))[:161] ** 2 / n_phases
    return np.asarray(2 * total / (rate * np.sum(window**2)))


@pytest.mark.parametrize("frequency", [50.0, 51.7])
@pytest.mark.parametrize("window", ["rectangular", "hann", "flat_top"])
def test_the_response_gets_the_mean_periodogram_of_a_square_wave_of_four_terms(
    window: str, frequency: float
) -> None:
    bare, found = added(MainsHum(ratio=0.1, frequency=frequency), window)
    n = samples_of(rig(1, 7, analyser=SETTINGS).analyser)
    turn = 2 * np.pi * np.arange(n) / n
    flat = (0.21557895, -0.41663158, 0.277263158, -0.083578947, 0.006947368)  # ISO 18431-2, flat top
    terms = {"rectangular": (1.0,), "hann": (0.5, -0.5), "flat_top": flat}[window]
    shape = np.sum([a * np.cos(k * turn) for k, a in enumerate(terms)], axis=0)
    wanted = own_transform(frequency, shape, 0.3)
    rms2 = 800 * bare.xx.mean(axis=1)
    # rounding: the hum stands out of spectra 1e4 times as large at resonances
    excess = (found.xx - bare.xx) / (0.1**2 * rms2[:, None])
    np.testing.assert_allclose(
        excess, np.broadcast_to(wanted[None, :, None], excess.shape), rtol=1e-8, atol=1e-9
    )


def test_on_the_grid_without_a_window_four_lines_hold_it_all() -> None:
    bare, found = added(MainsHum(ratio=0.1), "rectangular")
    excess = (found.xx - bare.xx)[0, :, 1] / bare.xx[0, :, 1].mean() / 160  # of the whole power of 161 lines
    lines = np.zeros(161)
    lines[[10, 30, 50, 70]] = 0.01 / np.array([1, 9, 25, 49])
    np.testing.assert_allclose(excess, lines, rtol=1e-9, atol=1e-15)  # rounding


def test_each_harmonic_has_its_own_amplitude() -> None:
    hum = MainsHum(ratio=0.1, second_harmonic=0.5, third_harmonic=0.2, higher_harmonics=2.0)
    bare, found = added(hum, "rectangular")
    excess = (found.xx - bare.xx)[0, :, 1] / bare.xx[0, :, 1].mean() / 160  # of the whole power of 161 lines
    lines = np.zeros(161)
    lines[[10, 20, 30, 50, 70]] = 0.01 * np.array([1, 0.5, 0.2, 2 / 5, 2 / 7]) ** 2
    np.testing.assert_allclose(excess, lines, rtol=1e-9, atol=1e-15)  # rounding


def test_nothing_of_it_reaches_the_force_or_the_mean_cross_spectrum() -> None:
    bare, found = added(MainsHum(ratio=1.0), "hann")
    np.testing.assert_array_equal(found.ff, bare.ff)
    np.testing.assert_array_equal(found.fx, bare.fx)


def test_coherence_drops_at_the_mains_lines_and_returns_between_them() -> None:
    bare, found = added(MainsHum(ratio=0.3, frequency=60.0), "hann")
    kept = (coherence(found) / coherence(bare))[0, :, 0]
    assert kept[12] < 0.5
    assert kept[20] > 0.999  # 100 Hz, eight lines from the fundamental and sixteen from the third


def test_harmonics_above_the_band_are_kept_out() -> None:
    bare, found = added(MainsHum(ratio=0.1, frequency=200.0), "rectangular")
    loud = np.flatnonzero((found.xx - bare.xx)[0, :, 0] > 1e-9 * bare.xx[0, :, 0].max())
    np.testing.assert_array_equal(loud, [40, 120])  # 200 and 600 Hz; 1000 and 1400 Hz are not there


def test_one_channel_may_hum_alone() -> None:
    bare, found = added(MainsHum(Channels(dofs(7)), ratio=0.1), "hann")
    np.testing.assert_array_equal(found.xx[..., 0], bare.xx[..., 0])
    assert (found.xx[..., 1] > bare.xx[..., 1]).any()


@pytest.mark.parametrize("excitation", ["periodic_random", "random"])
def test_records_hum_as_loud_as_expected_and_add_up_to_nothing_with_the_force(excitation: str) -> None:
    settings = {**SETTINGS, "window": "hann", "averages": 2000}
    setup = rig(1, excitation=excitation, analyser=settings)
    whole = chain(beam_system(), setup, [MainsHum(ratio=1.0, frequency=52.0, second_harmonic=0.6)])
    sampled, wanted = sampled_spectra(whole, np.random.default_rng(1), silent), expected_spectra(whole)
    near = [9, 10, 11, 12, 20, 21, 31, 32]  # where the hum is most of the response
    np.testing.assert_allclose(sampled.xx[0, near], wanted.xx[0, near], rtol=4 / np.sqrt(2000))
    unexplained = wanted.xx[0, near, 0] * wanted.ff[0, near, 0, 0].real * (1 - coherence(wanted)[0, near, 0])
    apart = np.abs(sampled.fx - wanted.fx)[0, near, 0, 0] / np.sqrt(unexplained / 2000)
    assert (apart < 4).all()


def test_the_same_seed_hums_at_the_same_phases() -> None:
    whole = chain(beam_system(), rig(1, analyser=SETTINGS), [MainsHum()])
    a, b = (sampled_spectra(whole, np.random.default_rng(5), silent) for _ in range(2))
    assert a.xx.tobytes() == b.xx.tobytes()
