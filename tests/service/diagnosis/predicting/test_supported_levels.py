"""Free noise of the force is kept where FRFs are as low as it makes H1, and left out where they are not."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.optimisation.tolerance_effects import MemberTolerance
from modallab.diagnosis.predicting.supported_levels import with_supported_force_noise
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.result import Verdict
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.loss_factor_error import LossFactorError
from modallab.rig.effect import Effect
from modallab.rig.hardware import Noise
from modallab.rig.measurement import Measurement
from tests.diagnosing import draw_measurement, model, rig

MASS = ExtraMass(at=Dof(5, "Y"), mass=0.1)


def undeclared(hidden: list[Effect], *, force_noise: float) -> Measurement:
    """A test of which FRFs and coherence alone are known, with a share of noise in the force."""
    setup = replace(rig(), noise=Noise(force_noise, 1e-6))
    test = draw_measurement(setup, hidden)
    return replace(
        test, setup=replace(rig(), noise=Noise(None, None)), force_spectrum=None, response_spectrum=None
    )


def proportional_noise(hidden: list[Effect]) -> Measurement:
    """The same with noise of the responses in proportion to themselves, and none of the force."""
    exact = undeclared(hidden, force_noise=0.0)
    rng = np.random.default_rng(0)
    averages, share = 100, 0.2
    noise = rng.standard_normal((2, *exact.frf.values.shape)) * np.sqrt(share / (2 * averages))
    values = exact.frf.values * (1 + noise[0] + 1j * noise[1])
    assert exact.coherence is not None
    return replace(
        exact,
        frf=replace(exact.frf, values=values),
        coherence=np.full(exact.coherence.shape, 1 / (1 + share)),
        averages=averages,
    )


@pytest.mark.parametrize("hidden", [[], [MASS]])
def test_frfs_tell_noise_of_the_force_from_other_noise(hidden: list[Effect]) -> None:
    for test, kept in ((undeclared(hidden, force_noise=0.1), True), (proportional_noise(hidden), False)):
        observed = observe(test, (), fraction=0.0)
        assert observed.free_levels.force_noise
        found = with_supported_force_noise(model(), test.setup, observed)
        assert found.free_levels.force_noise
        assert found.free_levels.biases_h1 is kept
        assert found.free_levels.response_noise


def test_a_model_that_is_a_little_wrong_does_not_contradict_noise_of_the_force() -> None:
    """At its resonances the loss rises and falls by more than the noise changes it."""
    variation = np.random.default_rng(0).normal(1.0, 0.02, len(model().members))
    wrong = [MemberTolerance(stiffness=tuple(variation.tolist())), LossFactorError(None, 0.7)]
    test = undeclared(wrong, force_noise=1e-3)
    found = with_supported_force_noise(model(), test.setup, observe(test, (), fraction=0.0))
    assert found.free_levels.biases_h1


def test_noise_of_the_responses_alone_is_no_missing_effect() -> None:
    found = diagnose(model(), proportional_noise([]))
    assert found.verdict is Verdict.NOTHING_MISSING
    assert any("in proportion to the responses" in note for note in found.notes)
    assert any("force_noise, response_noise, quantisation not judged" in note for note in found.notes)


def test_a_sensitivity_that_is_a_little_wrong_does_not_contradict_noise_of_the_force() -> None:
    """FRFs 0.5 % too high are higher than noise of a thousandth of the force makes them."""
    test = undeclared([], force_noise=1e-3)
    test = replace(test, frf=replace(test.frf, values=1.005 * test.frf.values))
    found = with_supported_force_noise(model(), test.setup, observe(test, (), fraction=0.0))
    assert found.free_levels.biases_h1
