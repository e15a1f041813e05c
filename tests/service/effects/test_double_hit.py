"""A hammer that comes back."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.diagnosis.diagnose import diagnose
from modallab.effects.double_hit import DoubleHit
from modallab.estimation.coherence import coherence
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra
from modallab.fe.damping import StructuralDamping
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.free_decay import impulse_responses_of
from modallab.rig.hardware import Exciter, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, dofs, rig, steel_beam

HEAVY = StructuralDamping(stiffness_coefficient=0.2)  # rings out within a record
SETUP = rig(1, 7, excitation="impact")


def struck(*effects: DoubleHit, window: str = "rectangular", noise: Noise | None = None) -> CrossSpectra:
    setup = rig(1, 7, excitation="impact", analyser={"window": window}, noise=noise or Noise())
    return expected_spectra(chain(beam_system(HEAVY), setup, effects))


def h1(spectra: CrossSpectra) -> ComplexArray:
    return ESTIMATORS["h1"](spectra)[0, :, :, 0]


def test_every_channel_hears_the_blow_and_its_smaller_repetition() -> None:
    single = chain(beam_system(HEAVY), SETUP)
    answers = impulse_responses_of(single, 0)
    later = 100  # samples
    delay = later / (answers.n_samples * SETUP.analyser.spacing)
    double = chain(beam_system(HEAVY), SETUP, [DoubleHit(ratio=0.4, delay=delay)])
    found = impulse_responses_of(double, 0).samples[0, :, later:]
    once = answers.samples[0]
    # the filter's ringing that wraps from one end of the answers to the other: 1e-6 of the peak
    np.testing.assert_allclose(
        found, once[:, later:] + 0.4 * once[:, :-later], atol=1e-6 * np.abs(once).max()
    )


def test_the_force_spectrum_ripples_with_the_inverse_of_the_delay() -> None:
    ratio, delay = 0.3, 0.02
    ripple = struck(DoubleHit(ratio=ratio, delay=delay)).ff / struck().ff
    freq = SETUP.analyser.freq
    wanted = 1 + ratio**2 + 2 * ratio * np.cos(2 * np.pi * freq * delay)  # |1 + r exp(-i omega tau)|^2
    # the filter's ringing, cut off with the record
    np.testing.assert_allclose(ripple[0, 1:-3, 0, 0].real, wanted[1:-3], rtol=5e-3)


def test_the_frf_stays_what_it_is_until_noise_shows_in_the_valleys() -> None:
    clean, double = struck(), struck(DoubleHit(ratio=0.8))
    scale = np.abs(h1(clean)).max()
    np.testing.assert_allclose(h1(double)[5:], h1(clean)[5:], atol=2e-3 * scale)
    noise = Noise(force=0.02, response=0.0)
    lost = {
        kind: 1 - coherence(struck(*hit, noise=noise))
        for kind, hit in (("1", []), ("2", [DoubleHit(ratio=0.8)]))
    }
    # at the bottom of the ripple the force is 25 times weaker
    assert lost["2"].max() > 8 * lost["1"].max()


@pytest.mark.parametrize("window", ["force", "force_exponential"])
def test_a_force_window_that_cuts_the_second_blow_off_spoils_the_frf(window: str) -> None:
    # it comes after a fifth of the record, where the force is cut off and the response is not
    late = DoubleHit(ratio=0.5, delay=0.2)
    wrong = np.abs(h1(struck(late, window=window)) / h1(struck(window=window)) - 1)[5:-5, 0]
    within = np.abs(
        h1(struck(DoubleHit(ratio=0.5, delay=0.02), window=window)) / h1(struck(window=window)) - 1
    )
    assert np.median(wrong) > 5 * np.median(within[5:-5, 0])
    assert np.median(wrong) > 0.05


def test_it_is_looked_for_where_something_strikes() -> None:
    assert DoubleHit.places(beam_system(), SETUP) == (None,)
    assert DoubleHit.places(beam_system(), rig(1, 7)) == ()


def test_a_diagnosis_names_it_with_its_size_and_its_delay() -> None:
    setting = ExcitationSetting("impact")
    analyser = Analyser(400.0, 201, averages=20, excitation=setting)
    setup = RigSetup(
        dofs(1), dofs(1, 7), exciter=Exciter("hammer"), noise=Noise(1e-4, 1e-4), analyser=analyser
    )
    hit = DoubleHit(ratio=0.25, delay=0.0137)
    rng = np.random.default_rng(1)
    measured = measure(steel_beam(HEAVY), setup, [hit], route=Route.SAMPLED, rng=rng)
    found = diagnose(steel_beam(HEAVY), measured, suspects=["double_hit", "gain_error"])
    (step,) = found.steps
    assert step.effect.kind == "double_hit"
    for name, value in hit.parameters.items():
        fitted = step.effect.parameters[name]
        assert abs(fitted.value - value) < 4 * fitted.standard_error, name
    # the weights are those of a Gaussian force, which scatters more than blows of one size do
    assert found.remaining_gap < 1.1
