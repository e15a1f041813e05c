"""Free noise of the force biases H1 as far as the FRFs of the prediction show it."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.free_levels import ALL_DECLARED
from modallab.diagnosis.residuals.h1_bias import share_of_bias
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.result import Verdict
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.stiffness_error import StiffnessError
from modallab.rig.effect import Effect
from modallab.rig.expected import expected_spectra
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


def bias(test: Measurement, hidden: list[Effect]) -> float:
    """The median change of ln |H1| by noise in the prediction with the hidden effects."""
    predictor = SingleTestPredictor.of(model(), test.setup, observe(test, (), fraction=0.0))
    declared = replace(predictor.observed, free_levels=ALL_DECLARED)
    free, without = (
        replace(predictor, observed=each).predict(hidden).h for each in (predictor.observed, declared)
    )
    return float(np.median(np.abs(np.log(np.abs(free / without)))))


@pytest.mark.parametrize("hidden", [[], [MASS]])
def test_frfs_tell_noise_of_the_force_from_other_noise(hidden: list[Effect]) -> None:
    of_force = bias(undeclared(hidden, force_noise=0.1), hidden)
    of_responses = bias(proportional_noise(hidden), hidden)
    assert of_force > 0.05  # the noise is a tenth of the power: ln 1.1, and in no fit below half of it
    assert of_responses < 0.01  # a few standard errors of a mean: 3 % a line, 960 lines


def test_a_wrong_member_beside_noise_of_the_responses_needs_no_gain() -> None:
    """Before the member is found the FRFs deviate by more than the bias."""
    test = proportional_noise([StiffnessError(Members((3,)), 0.7)])
    found = diagnose(model(), test, suspects=["stiffness_error", "gain_error"])
    assert found.verdict is Verdict.EXPLAINED
    assert [(step.effect.kind, step.effect.at) for step in found.steps] == [
        ("stiffness_error", Members((3,)))
    ]


def test_noise_of_the_responses_alone_is_no_missing_effect() -> None:
    found = diagnose(model(), proportional_noise([]))
    assert found.verdict is Verdict.NOTHING_MISSING
    assert any("proportion to the responses" in note for note in found.notes)
    assert any("force_noise, response_noise, quantisation not judged" in note for note in found.notes)


def test_lines_that_no_source_drives_tell_nothing() -> None:
    """Noise over a force of nothing is infinite there."""
    test = proportional_noise([])
    predictor = SingleTestPredictor.of(model(), test.setup, observe(test, (), fraction=0.0))
    spectra = expected_spectra(predictor.chain(()))
    observed = replace(predictor.observed, usable=predictor.observed.usable & (spectra.freq > 100)[:, None])
    ratio = np.full((len(spectra.ff), len(spectra.freq), 1), 0.2)
    known = share_of_bias(spectra, ratio, observed)
    ratio[:, spectra.freq <= 100] = 1e300
    assert share_of_bias(spectra, ratio, observed) == known
