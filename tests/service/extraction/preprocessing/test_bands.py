from itertools import pairwise

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError, NoModeInBandError
from modallab.extraction.preprocessing.bands import (
    coherent_lines,
    find_bands,
    mode_indicator,
    requested_bands,
)
from modallab.extraction.single_mode.method import ModeFit
from tests.service.extraction.conftest import Beam


def mobility(freq: FloatArray, *frequencies: float) -> ComplexArray:
    modes = [np.abs(freq * ModeFit(f, 0.01, 1.0).response(freq)) for f in frequencies]
    return np.asarray(sum(modes), complex)[:, None]


def test_every_mode_of_the_beam_has_its_band(roving_beam: Beam, freq: FloatArray) -> None:
    axis = freq[1:]
    velocity = 2j * np.pi * axis[:, None] * roving_beam.receptance(axis)
    bands = find_bands(mode_indicator(velocity, np.ones(400, bool)))
    frequencies = roving_beam.frequencies.mean(axis=1)
    assert len(bands) == 8
    for band, frequency in zip(bands, frequencies, strict=True):
        assert axis[band.first] < frequency < axis[band.last]
        assert abs(axis[band.peak] - frequency) < 3  # Hz: a line and the wander
    assert all(a.last == b.first for a, b in pairwise(bands))


def test_a_weak_response_counts_as_much_as_a_strong_one() -> None:
    freq = np.arange(10.0, 100.0)
    both = np.hstack([mobility(freq, 30.0), 1e-4 * mobility(freq, 70.0)])
    assert [freq[band.peak] for band in find_bands(mode_indicator(both, np.ones(90, bool)))] == [30, 70]


def test_an_incoherent_line_does_not_split_a_peak() -> None:
    freq = np.arange(10.0, 100.0)
    coherence = np.ones((90, 1))
    coherence[freq == 50] = 0.005
    spoilt = mobility(freq, 50.4)
    spoilt[freq == 50] = 0
    coherent = coherent_lines(coherence, 100)
    assert list(freq[~coherent]) == [50]
    assert len(find_bands(mode_indicator(spoilt, coherent))) == 1


def test_coherence_of_noise_is_seldom_taken_for_signal() -> None:
    rng = np.random.default_rng(4)
    noise = rng.beta(1, 49, size=(20_000, 1))  # coherence of two independent signals, 50 averages
    # 1 % by design, known to 0.07 % from 20,000 lines
    assert coherent_lines(noise, 50).mean() == pytest.approx(0.01, abs=0.003)


def test_the_most_prominent_peaks_are_kept_in_rising_frequency() -> None:
    freq = np.arange(10.0, 100.0)
    high = mobility(freq, 30.0, 80.0) + 0.05 * mobility(freq, 55.0)
    bands = find_bands(mode_indicator(high, np.ones(90, bool)), n_modes=2)
    assert [freq[band.peak] for band in bands] == [30, 80]


def test_nothing_to_see_is_said() -> None:
    with pytest.raises(NoModeInBandError, match="no resonance was found"):
        find_bands(np.linspace(1, 2, 50))
    with pytest.raises(NoModeInBandError, match="zero"):
        mode_indicator(np.zeros((50, 2), complex), np.ones(50, bool))


def test_given_bands_take_their_highest_peak_and_not_a_flank() -> None:
    freq = np.arange(10.0, 100.0)
    indicator = mode_indicator(mobility(freq, 30.0) + 0.1 * mobility(freq, 45.0), np.ones(90, bool))
    bands = requested_bands(freq, indicator, [(32, 50), (25, 31)])
    assert [freq[band.peak] for band in bands] == [30, 45]


def test_a_band_upside_down_is_named() -> None:
    with pytest.raises(InvalidInputError, match="30 to 20 Hz"):
        requested_bands(np.arange(100.0), np.ones(100), [(30, 20)])
