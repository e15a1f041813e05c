"""Noise of the force gauge, its spectra worked out from matrices put together by hand."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.effects.force_noise import ForceNoise
from modallab.estimation.coherence import coherence
from modallab.estimation.estimator import ESTIMATORS
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Exciter, Noise
from modallab.rig.setup import RigSetup
from tests import bernoulli
from tests.rigs import beam_system, dofs, rig

SETUP = rig(1, 7, exciter=Exciter(armature_mass=0.05))
FREQ = SETUP.analyser.freq


def by_hand() -> tuple[ComplexArray, FloatArray]:
    """Inertance (n_lines, 2) and the force spectrum's drop-out [5.4] (n_lines,), both from 0 Hz on.

    At 0 Hz the loss that goes with mass holds the beam still.
    """
    h = np.zeros((len(FREQ), 2), complex)
    h[1:] = bernoulli.inertance(*bernoulli.matrices({}, {}), FREQ[1:], (1, 7))
    return h, 1 / np.abs(1 + 0.05 * h[:, 0]) ** 2


@pytest.mark.parametrize("ratio", [1e-3, 0.3])
def test_where_the_force_drops_out_h1_is_low_and_coherence_with_it(ratio: float) -> None:
    """H1 = H / (1 + r), H2 = H, coherence 1 / (1 + r): 1992 thesis [5.6-5.8]; r, of the band's mean."""
    spectra = expected_spectra(chain(beam_system(), SETUP, [ForceNoise(ratio=ratio)]))
    h, force = by_hand()
    r = (ratio * force.mean() / force)[:, None]
    h1, h2 = (ESTIMATORS[kind](spectra)[0, :, :, 0] for kind in ("h1", "h2"))
    # 0 Hz left out, where H is none. Rounding of two solutions: 1e-16 times the ratio of eigenvalues, 1e6
    np.testing.assert_allclose(h1[1:], (h / (1 + r))[1:], rtol=1e-6, atol=1e-9 * np.abs(h).max())
    np.testing.assert_allclose(h2[1:], h[1:], rtol=1e-6, atol=1e-9 * np.abs(h).max())
    np.testing.assert_allclose(coherence(spectra)[0, 1:], (1 / (1 + r)).repeat(2, axis=1)[1:], rtol=1e-6)


def test_it_is_worst_at_the_resonances_of_the_beam() -> None:
    drop = 1 - coherence(expected_spectra(chain(beam_system(), SETUP, [ForceNoise(ratio=1e-3)])))[0, 1:, 0]
    peaks = FREQ[1:][1:-1][(drop[1:-1] > drop[:-2]) & (drop[1:-1] > drop[2:])]
    # [5.4]: the force is least where 1 + m_s H is greatest, at the bare beam's resonances; a line is 2 Hz
    for frequency in bernoulli.FREQUENCIES:
        assert np.abs(peaks - frequency).min() <= SETUP.analyser.spacing


def test_a_flat_force_spectrum_is_biased_alike_at_every_line() -> None:
    spectra = expected_spectra(chain(beam_system(), rig(1, 7, noise=Noise(force=0.25))))
    h, _ = by_hand()
    np.testing.assert_allclose(coherence(spectra)[0, 1:], 1 / 1.25, rtol=1e-12)  # rounding
    found = ESTIMATORS["h1"](spectra)[0, 1:, :, 0]
    np.testing.assert_allclose(found, h[1:] / 1.25, rtol=1e-6, atol=1e-9 * np.abs(h).max())


def test_declared_and_named_noise_add_in_power() -> None:
    both = expected_spectra(chain(beam_system(), rig(1, noise=Noise(force=0.1)), [ForceNoise(ratio=0.2)]))
    np.testing.assert_allclose(coherence(both)[0, 1:], 1 / 1.3, rtol=1e-12)  # rounding


def test_noise_of_one_gauge_of_two_is_in_the_spectrum_of_that_one_alone() -> None:
    setup = RigSetup(dofs(1, 21), dofs(7))
    noisy = expected_spectra(chain(beam_system(), setup, [ForceNoise(at=Dof(21, "Y"), ratio=0.5)]))
    clean = expected_spectra(chain(beam_system(), setup))
    found = noisy.ff[0] / clean.ff[0, 0, 0, 0]
    np.testing.assert_allclose(found, np.broadcast_to(np.diag([1.0, 1.5]), found.shape), atol=1e-12)


def test_noise_of_a_gauge_that_a_hammer_brings_to_one_place_is_in_those_runs_alone() -> None:
    setup = RigSetup(dofs(1, 21), dofs(7), Exciter("hammer"))
    spectra = expected_spectra(chain(beam_system(), setup, [ForceNoise(at=Dof(21, "Y"), ratio=0.5)]))
    np.testing.assert_allclose(coherence(spectra)[:, 1:, 0], np.array([[1.0], [1 / 1.5]]).repeat(400, axis=1))
