from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.frf import FrfSet
from modallab.extraction.averaging.shared_noise import shared_noise_fraction
from modallab.extraction.extract import extract
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.bands import find_bands, mode_indicator
from modallab.extraction.preprocessing.fit_windows import place_windows
from modallab.extraction.preprocessing.responses import responses_of
from modallab.extraction.single_mode.damping_models import DAMPING_MODELS
from modallab.extraction.single_mode.fit_data import window_data
from modallab.extraction.single_mode.fitting import fit_all
from modallab.extraction.single_mode.method import EXTRACTION_METHODS
from tests.service.extraction.conftest import Beam

AVERAGES = 100.0
COHERENCE = 0.98


def measured(frf: FrfSet, seed: int, share: float) -> tuple[FrfSet, FloatArray]:
    """Return FRFs whose random error is of one size, this share of its square the same in all."""
    rng = np.random.default_rng(seed)
    n_freq, n_out, _ = frf.values.shape

    def drawn(n: int) -> FloatArray:
        return np.asarray(rng.standard_normal((n_freq, n, 1)) + 1j * rng.standard_normal((n_freq, n, 1)))

    error = np.sqrt((1 - COHERENCE) / (2 * AVERAGES * COHERENCE))
    noise = error * (np.sqrt(share) * drawn(1) + np.sqrt(1 - share) * drawn(n_out))
    return replace(frf, values=frf.values * (1 + noise)), np.full((n_freq, n_out), COHERENCE)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_what_errors_have_in_common_is_found(plain_beam: Beam, freq: FloatArray, share: float) -> None:
    found = []
    for seed in range(4):
        frf, coherence = measured(plain_beam.frf(freq), seed, share)
        responses = responses_of(frf, coherence, AVERAGES)
        indicator = mode_indicator(responses.mobility, responses.coherent)
        windows = place_windows(
            responses.mobility, indicator, find_bands(indicator), base=8, widths=3.0, leave_out=0
        )
        data = window_data(responses.freq, responses.receptance, responses.variance, windows, None, 0)
        law = DAMPING_MODELS[Damping.STRUCTURAL]
        settled = fit_all(EXTRACTION_METHODS["dobson"], law, data)
        found.append(shared_noise_fraction(law, data, settled, windows.index))
    # some 50 independent lines near resonances know a common error to a few hundredths of its share; fits
    # through other lines in one FRF than in the next take a tenth of it out
    assert 0.85 * share - 0.05 < np.mean(found) < share + 0.05
    assert np.std(found) < 0.1


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_standard_errors_of_means_hold_what_no_mean_lessens(
    plain_beam: Beam, freq: FloatArray, share: float
) -> None:
    scores = []
    for seed in range(8):
        frf, coherence = measured(plain_beam.frf(freq), seed, share)
        model = extract(frf, coherence=coherence, averages=AVERAGES)
        assert ("common to all FRFs" in model.choices["means"]) == (share > 0)
        for m, mode in enumerate(model.modes):
            off = (
                mode.frequency - plain_beam.frequencies[m, 0],
                mode.loss_factor - plain_beam.loss_factors[m, 0],
            )
            scores.append(off[0] / mode.standard_errors["frequency"])
            scores.append(off[1] / mode.standard_errors["loss_factor"])
    # 128 standard scores: their rms is known to 6 %; without the common part it would be 3.3 at a share of 1
    assert 0.75 < np.sqrt(np.mean(np.square(scores))) < 1.25


def test_one_frf_alone_has_nothing_in_common(plain_beam: Beam, freq: FloatArray) -> None:
    one = plain_beam.frf(freq)
    alone = FrfSet(freq, one.values[:, :1], one.outputs[:1], one.inputs, one.kind)
    model = extract(alone, coherence=np.full((401, 1), COHERENCE), averages=AVERAGES)
    assert "common to all FRFs" not in model.choices["means"]
