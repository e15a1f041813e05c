"""Coherence without response spectra: compared where the log book declares the noise, else not."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.predicting.limitations import limitations
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.effects.force_noise import ForceNoise
from modallab.effects.overload import Overload
from modallab.rig.effect import Effect
from modallab.rig.hardware import Noise, NoiseDensity
from modallab.rig.measurement import Measurement
from tests.diagnosing import draw_measurement, model, rig


def bare(test: Measurement, *, force: bool = False) -> Measurement:
    """An uploaded test of FRFs and coherence, perhaps with force spectra."""
    kept = test.force_spectrum if force else None
    return replace(test, route=None, force_spectrum=kept, response_spectrum=None)


def gaps(test: Measurement) -> dict[str, float]:
    predictor = SingleTestPredictor.of(model(), test.setup, observe(test, (), fraction=0.25))
    return dict(predictor.residual(()).gaps(predictor.observed.usable))


@pytest.mark.parametrize(("kind", "window"), [("periodic_random", "rectangular"), ("random", "hann")])
@pytest.mark.parametrize("force", [False, True])
def test_an_exact_model_leaves_random_error_in_the_coherence(kind: str, window: str, force: bool) -> None:
    test = draw_measurement(rig(kind=kind, window=window, noise=1e-4), seed=3)
    found = gaps(bare(test, force=force))
    # 6 x 160 lines, of which a window leaves half independent: 7 % of squares of a heavy tail
    assert found["response"] == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize(
    "hidden", [ForceNoise(None, 0.02), Overload(None, 1.5)], ids=lambda effect: effect.kind
)
def test_what_lowers_the_coherence_is_named(hidden: Effect) -> None:
    test = bare(draw_measurement(rig(kind="random", window="hann", noise=1e-4), [hidden], seed=3))
    found = diagnose(model(), test, suspects=["force_noise", "response_noise", "overload", "extra_mass"])
    assert [step.effect.kind for step in found.steps] == [hidden.kind]


@pytest.mark.parametrize("noise", [Noise(None, None), Noise(NoiseDensity(1e-8), NoiseDensity(1e-8))])
def test_a_coherence_that_nothing_declares_is_not_compared(noise: Noise) -> None:
    test = bare(draw_measurement(rig(noise=1e-4), seed=3))
    source = replace(test.setup.analyser.excitation, level=None)
    analyser = replace(test.setup.analyser, excitation=source)
    test = replace(test, setup=replace(test.setup, noise=noise, analyser=analyser))
    observed = observe(test, (), fraction=0.25)
    assert observed.incoherent is None
    assert any("not compared" in note for note in limitations(test, observed))


def test_blows_of_unequal_size_widen_the_errors_of_spectra_over_the_force() -> None:
    """The force spectrum of the average is not known where no spectrum is."""
    test = bare(draw_measurement(rig(noise=1e-4), seed=3))
    variances = []
    for scatter in (0.0, 0.2):
        source = replace(test.setup.analyser.excitation, level_scatter=scatter)
        setup = replace(test.setup, analyser=replace(test.setup.analyser, excitation=source))
        variance = observe(replace(test, setup=setup), (), fraction=0.25).incoherent_variance
        assert variance is not None
        variances.append(variance)
    # exp(4 s^2) - 1 of the power of one blow, over the averages; rounding
    wider = (np.exp(4 * 0.2**2) - 1) / test.averages
    np.testing.assert_allclose(variances[1] - variances[0], wider, rtol=1e-9)
