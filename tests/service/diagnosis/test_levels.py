"""A second level tells a hardening spring from a plain one that looks alike at the first."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.ground_spring import GroundSpring
from modallab.rig.effect import Effect
from modallab.rig.setup import RigSetup
from tests.diagnosing import exact, model, rig

HERE = Dof(9, "Y")
CUBIC = CubicStiffness(HERE, 3e8)


def at_level(setup: RigSetup, factor: float) -> RigSetup:
    excitation = replace(setup.analyser.excitation, level=factor)
    return replace(setup, analyser=replace(setup.analyser, excitation=excitation))


def frfs_only(setup: RigSetup, effect: Effect) -> Predictor:
    """A predictor of what an effect makes of the FRFs, without random error, compared with nothing else."""
    measured = replace(exact(setup, [effect]), force_spectrum=None, response_spectrum=None)
    observed = replace(observe(measured, (), fraction=0.0), incoherent=None, incoherent_variance=None)
    return SingleTestPredictor.of(model(), setup, observed)


def apart(setup: RigSetup, truth: Effect, other: Effect) -> float:
    """How many standard deviations lie between two explanations in one measurement of FRFs."""
    predictor = frfs_only(setup, truth)
    return float(np.linalg.norm(predictor.residual([other]).vector(predictor.observed.fitted)))


@pytest.mark.parametrize("kind", ["periodic_random", "random"])
def test_three_times_the_level_separates_a_cubic_from_a_spring_fitted_to_the_same_frfs(kind: str) -> None:
    setup = rig(kind=kind, window="rectangular" if kind == "periodic_random" else "hann")
    first = frfs_only(setup, CUBIC)
    (spring,) = fit(first, [GroundSpring(HERE, 30.0)]).effects
    (cubic,) = fit(first, [replace(CUBIC, stiffness=0.7 * CUBIC.stiffness)]).effects
    assert apart(setup, CUBIC, GroundSpring(HERE, 1e-6)) > 8, "the cubic hardly shows: nothing was shown"
    # At one level a measurement prefers neither: three standard deviations are what chance does.
    assert apart(setup, CUBIC, spring) < 3
    assert apart(setup, CUBIC, cubic) < 3
    louder = at_level(setup, 3.0)
    assert apart(louder, CUBIC, spring) > 15
    assert apart(louder, CUBIC, cubic) < 3


def test_a_plain_spring_is_the_same_at_every_level() -> None:
    setup = rig()
    for factor in (0.1, 3.0):
        louder = at_level(setup, factor)
        spring, other = GroundSpring(HERE, 50.0), GroundSpring(HERE, 51.0)
        # all spectra grow alike, rounding apart
        assert apart(louder, spring, other) == pytest.approx(apart(setup, spring, other), rel=1e-6)
