"""Mains hum in force and response: its lines tell nothing of the FRF, and the rest is as it was."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.diagnosis.predicting.limitations import limitations
from modallab.diagnosis.residuals.channel_spectra import ChannelSpectra
from modallab.diagnosis.residuals.mains_lines import force_shares
from modallab.diagnosis.residuals.observe import observe
from modallab.rig.measurement import Measurement
from tests.diagnosing import draw_measurement, predicting, rig
from tests.humming import with_hum as with_sine

LINE = 24  # 60 Hz at 2.5 Hz a line: no resonance is near its multiples


def with_hum(test: Measurement, in_force: float, in_response: float, order: int = 1) -> Measurement:
    """Return an uploaded measurement that hums in both channels at a multiple of 60 Hz."""
    return with_sine(test, order * LINE, in_force, in_response)


@pytest.fixture(scope="module")
def quiet() -> Measurement:
    """A test without hum."""
    return draw_measurement(rig(kind="random", window="hann", noise=1e-5), seed=3)


def flagged(test: Measurement) -> np.ndarray:
    """Lines at which some channel shows hum."""
    shares = force_shares(test.setup.analyser, ChannelSpectra.of(test))
    return np.flatnonzero(shares.any(axis=1))


def test_hum_is_seen_at_its_own_lines_alone(quiet: Measurement) -> None:
    np.testing.assert_array_equal(flagged(with_hum(quiet, 1.0, 3.0)), [LINE - 1, LINE, LINE + 1])


def test_a_quiet_test_has_no_such_line(quiet: Measurement) -> None:
    assert not flagged(quiet).size


def test_a_harmonic_counts_where_the_fundamental_hums(quiet: Measurement) -> None:
    harmonic = with_hum(quiet, 1.0, 3.0, order=2)
    assert not flagged(harmonic).size
    both = flagged(with_hum(harmonic, 1.0, 3.0))
    np.testing.assert_array_equal(both, [*range(LINE - 1, LINE + 2), *range(2 * LINE - 1, 2 * LINE + 2)])


def test_without_spectra_the_coherence_tells_it(quiet: Measurement) -> None:
    humming = replace(with_hum(quiet, 0.3, 3.0), force_spectrum=None, response_spectrum=None)
    np.testing.assert_array_equal(flagged(humming), [LINE - 1, LINE, LINE + 1])


def test_lines_too_coarse_to_tell_are_left_as_they_are(quiet: Measurement) -> None:
    humming = with_hum(quiet, 1.0, 3.0)
    coarse = replace(humming.setup.analyser, frequency_max=4000.0)
    spectra = ChannelSpectra.of(humming)
    assert not force_shares(coarse, replace(spectra, freq=10 * spectra.freq)).any()


def test_frfs_at_its_lines_have_no_weight_and_others_as_before(quiet: Measurement) -> None:
    before = observe(replace(quiet, route=None), (), fraction=0.0)
    predictor, observed = predicting(with_hum(quiet, 1.0, 3.0))
    hums = np.isin(np.arange(161), [LINE - 1, LINE, LINE + 1])
    np.testing.assert_allclose(observed.error[~hums], before.error[~hums], rtol=1e-9)  # rounding
    gaps = predictor.residual(()).gaps(observed.usable & hums[:, None])
    assert gaps["frf"] < 0.01
    assert gaps["force"] < 2.0  # the hum there is a standard deviation of the logarithm
    assert predictor.residual(()).gaps(observed.usable)["frf"] == pytest.approx(1.0, abs=0.1)  # 1,800 squares


def test_the_share_of_hum_in_the_force_is_that_of_its_spectrum(quiet: Measurement) -> None:
    humming = with_hum(quiet, 0.3, 3.0)
    assert humming.force_spectrum is not None
    level = np.median(humming.force_spectrum, axis=0)[:, 0]
    true = 0.09 * 2 / 3 * quiet.force_spectrum.mean(axis=0)[:, 0] / level  # type: ignore[union-attr]
    shares = force_shares(humming.setup.analyser, ChannelSpectra.of(humming))[LINE]
    # The largest of three lines, which scatter by 10 %, and 10 % that chance may hide
    np.testing.assert_allclose(shares, true / (1 + true) + 0.1, atol=0.3)


def test_a_test_that_hums_says_so(quiet: Measurement) -> None:
    humming = with_hum(quiet, 0.3, 3.0)
    both = with_hum(humming, 0.3, 3.0, order=2)
    n = len(quiet.frf.outputs)
    for hums, frequencies in ((humming, "60"), (both, "60, 120")):
        test = replace(hums, force_spectrum=None, response_spectrum=None)
        (note,) = [note for note in limitations(test, observe(test, (), fraction=0.0)) if "hum" in note]
        assert note.startswith(f"mains hum: the coherence of {n} of {n} responses falls at {frequencies} Hz")
    uploaded = replace(quiet, route=None)
    assert not any("hum" in note for note in limitations(uploaded, observe(uploaded, (), fraction=0.0)))
