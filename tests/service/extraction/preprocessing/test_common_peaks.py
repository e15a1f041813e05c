import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.extraction.preprocessing.bands import find_bands, mode_indicator
from modallab.extraction.preprocessing.common_peaks import CommonPeaks, find_common
from modallab.extraction.preprocessing.responses import Responses, responses_of
from tests.synthetic import HAMMERED, hammered

BELOW = HAMMERED[:5]  # Hz: where the force is well above its noise


def common(responses: Responses, n_modes: int | None = None) -> CommonPeaks:
    return find_common(responses, indicator(responses), n_modes)


def indicator(responses: Responses) -> FloatArray:
    return mode_indicator(responses.mobility, responses.coherent)


def places(peaks: CommonPeaks, responses: Responses) -> FloatArray:
    return np.asarray(responses.freq[[band.peak for band in peaks.bands]])


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("n_frf", [3, 6])
def test_peaks_that_every_frf_has_elsewhere_are_noise_and_named(seed: int, n_frf: int) -> None:
    responses = responses_of(hammered(seed, n_frf), None, 100.0)
    found = common(responses)
    peaks = places(found, responses)
    assert len(find_bands(indicator(responses))) > 60
    # lines are 0.25 Hz apart, and noise moves the highest line of the upper modes by one or two
    away = np.abs(peaks[:, None] - HAMMERED)
    assert away.min(axis=1).max() < 0.6, "no peak is kept that is none"
    assert (away[:, : len(BELOW)].min(axis=0) < 0.3).all(), "no mode is lost where the force is"
    assert len(found.notes) == 1
    assert "classified as noise" in found.notes[0]


def test_of_the_common_peaks_the_most_prominent_are_kept() -> None:
    responses = responses_of(hammered(1, 3), None, 100.0)
    assert np.abs(places(common(responses, 3), responses)[:, None] - BELOW).min(axis=1).max() < 0.3


def test_peaks_at_frequencies_that_move_with_the_frf_are_modes_all_the_same() -> None:
    # twelve modes a tenth of a line wide; every accelerometer moves them by up to 3 lines
    freq: FloatArray = np.arange(1.0, 1300.0)
    rng = np.random.default_rng(0)
    moved = np.arange(100.0, 1300.0, 100.0)[:, None] * (1 - 0.004 * rng.uniform(size=(12, 5)))
    eigenvalues = (2 * np.pi * moved) ** 2 * (1 + 1e-4j)
    omega = 2 * np.pi * freq[:, None, None]
    inertance = np.asarray((-(omega**2) / (eigenvalues - omega**2)).sum(axis=1))
    dofs = tuple(Dof(node, "X") for node in range(1, 6))
    frf = FrfSet(freq, inertance[:, :, None], dofs, (Dof(30, "X"),), FrfKind.INERTANCE)
    responses = responses_of(frf, None, 100.0)
    assert len(find_bands(indicator(responses))) >= 12
    assert not common(responses).notes


def test_where_coherence_tells_noise_or_there_is_one_frf_all_peaks_stay() -> None:
    frf = hammered(0, 3)
    told = responses_of(frf, np.full(frf.values.shape, 0.99), 100.0)
    alone = responses_of(hammered(0, 1), None, 100.0)
    for responses in (told, alone):
        assert common(responses) == CommonPeaks(find_bands(indicator(responses)))
