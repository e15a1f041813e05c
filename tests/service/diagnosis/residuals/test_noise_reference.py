"""Tests of noise stated as a ratio to a mean force, measured or expected."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.diagnosis.predicting.limitations import limitations
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.stinger_axial import StingerAxial
from modallab.fe.assembly import assemble
from modallab.rig.chain import chain
from modallab.rig.effect import Effect
from modallab.rig.expected import expected_spectra, noise_free, noise_in_lines
from modallab.rig.hardware import Noise, NoiseDensity
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.diagnosing import model, rig

RATIO = 1e-3
# The armature resonates on the stinger at 130 Hz: the mean force is three times the expected one.
HIDDEN: tuple[Effect, ...] = (ExciterArmature(mass=0.2), StingerAxial(stiffness=2e5, loss_factor=0.1))


def expected_noise(setup: RigSetup) -> float:
    """Return the noise of the force, N^2/Hz, at the ratio to the expected force."""
    expected = chain(assemble(model()), setup)
    return float(noise_in_lines(expected, noise_free(expected))[0, 0])


def imported(setup: RigSetup, noise: Noise, effects: tuple[Effect, ...] = HIDDEN) -> Measurement:
    """Return a test with some noise, imported with a log book that states its ratio."""
    made = replace(setup, noise=noise)
    test = measure(model(), made, effects, route=Route.DRAWN, rng=np.random.default_rng(3))
    return replace(test, setup=setup, route=None)


def predictor_of(test: Measurement) -> SingleTestPredictor:
    return SingleTestPredictor.of(model(), test.setup, observe(test, (), fraction=0.25))


@pytest.fixture(scope="module", params=["periodic_random", "random"])
def setup(request: pytest.FixtureRequest) -> RigSetup:
    window = "hann" if request.param == "random" else "rectangular"
    return replace(rig(kind=request.param, window=window), noise=Noise(RATIO, RATIO))


def test_a_ratio_to_the_expected_force_is_recognised(setup: RigSetup) -> None:
    test = imported(setup, Noise(NoiseDensity(expected_noise(setup)), RATIO))
    predictor = predictor_of(test)
    gaps = predictor.residual(HIDDEN).gaps(predictor.observed.usable)
    # 160 lines of 11 responses: a mean square of 1760 and more data scatters by 3 %
    assert all(gap == pytest.approx(1.0, abs=0.12) for gap in gaps.values()), gaps
    assert any(
        "fitted between that ratio to either" in note for note in limitations(test, predictor.observed)
    )


def test_a_ratio_to_the_measured_force_is_recognised(setup: RigSetup) -> None:
    predictor = predictor_of(imported(setup, Noise(RATIO, RATIO)))
    gaps = predictor.residual(HIDDEN).gaps(predictor.observed.usable)
    assert all(gap == pytest.approx(1.0, abs=0.12) for gap in gaps.values()), gaps


def test_a_ratio_of_a_test_made_here_is_to_the_measured_force(setup: RigSetup) -> None:
    made = measure(model(), setup, HIDDEN, route=Route.DRAWN, rng=np.random.default_rng(3))
    predictor = predictor_of(replace(made, route=Route.DRAWN))
    assert predictor.observed.free_levels.expected_force_noise is None


def test_without_a_missing_effect_both_readings_are_one(setup: RigSetup) -> None:
    predictor = predictor_of(imported(setup, Noise(RATIO, RATIO), ()))
    expected = expected_spectra(predictor.chain(()))
    assert predictor.observed.with_levels(expected, predictor.lines) is expected
