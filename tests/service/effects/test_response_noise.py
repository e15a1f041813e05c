"""Noise of the response channels, their spectra worked out from matrices put together by hand."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.effects.response_noise import ResponseNoise
from modallab.estimation.coherence import coherence
from modallab.estimation.estimator import ESTIMATORS
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Accelerometers, Noise
from tests import bernoulli
from tests.rigs import beam_system, rig

NODES = (1, 7, 11)
FREQ = rig(1).analyser.freq


def by_hand() -> tuple[ComplexArray, FloatArray]:
    """Inertance and its square over the mean of the band, (n_lines, 3), from 0 Hz on.

    The force of an ideal rig is flat, so that the responses' spectra go with that square. At 0 Hz the loss
    that goes with mass holds the beam still.
    """
    h = np.zeros((len(FREQ), len(NODES)), complex)
    h[1:] = bernoulli.inertance(*bernoulli.matrices({}, {}), FREQ[1:], NODES)
    return h, np.abs(h) ** 2 / (np.abs(h) ** 2).mean(axis=0)


@pytest.mark.parametrize("ratio", [1e-5, 1e-3, 0.5])
def test_h2_is_high_by_what_each_channel_has_over_its_own_mean_and_h1_stays(ratio: float) -> None:
    """H1 = H, H2 = H (1 + r), coherence 1 / (1 + r): 1992 thesis [5.6-5.8]."""
    spectra = expected_spectra(chain(beam_system(), rig(*NODES), [ResponseNoise(ratio=ratio)]))
    h, size = by_hand()
    r = ratio / size[1:]
    h1, h2 = (ESTIMATORS[kind](spectra)[0, 1:, :, 0] for kind in ("h1", "h2"))
    # Rounding of two solutions, 1e-16 times the ratio of the beam's eigenvalues, 1e6, on H at resonance; in
    # antiresonances, down to 1e-4 of that, it weighs as much more.
    np.testing.assert_allclose(h1, h[1:], rtol=1e-6, atol=1e-9 * np.abs(h).max())
    np.testing.assert_allclose(h2, h[1:] * (1 + r), rtol=1e-5)
    np.testing.assert_allclose(coherence(spectra)[0, 1:], 1 / (1 + r), rtol=1e-5)


def test_coherence_is_least_in_antiresonances() -> None:
    spectra = expected_spectra(chain(beam_system(), rig(1), [ResponseNoise(ratio=1e-3)]))
    h, _ = by_hand()
    band = slice(5, -5)  # away from where the beam is held at 0 Hz
    g2, size = coherence(spectra)[0, band, 0], np.abs(h[band, 0])
    found, wanted = ((v[1:-1] < v[:-2]) & (v[1:-1] < v[2:]) for v in (g2, size))
    np.testing.assert_array_equal(found, wanted)
    assert found.sum() >= 7  # one between every two of the modes at a drive point


@pytest.mark.parametrize("roving", [False, True])
def test_noise_in_every_run_is_to_the_mean_of_its_own_channels(roving: bool) -> None:
    setup = rig(*NODES, noise=Noise(response=0.01), accelerometers=Accelerometers(roving=roving))
    spectra = expected_spectra(chain(beam_system(), setup))
    clean = expected_spectra(chain(beam_system(), rig(*NODES))).ff[0, 0, 0, 0].real
    h, _ = by_hand()
    added = (spectra.xx[:, :, 0].T if roving else spectra.xx[0]) - clean * np.abs(h) ** 2
    mean = clean * (np.abs(h) ** 2).mean(axis=0)
    # rounding as above, on the difference of what is up to 1e2 times the mean and 1e4 times the noise
    np.testing.assert_allclose(added / mean, 0.01, atol=1e-5)


def test_declared_and_named_noise_add_in_power() -> None:
    both = expected_spectra(
        chain(beam_system(), rig(1, noise=Noise(response=0.1)), [ResponseNoise(ratio=0.2)])
    )
    _, size = by_hand()
    np.testing.assert_allclose(coherence(both)[0, 1:, 0], 1 / (1 + 0.3 / size[1:, 0]), rtol=1e-5)  # as above
