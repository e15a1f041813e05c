"""Noise of a force channel that no log book declares: whether the FRFs support it."""

from dataclasses import replace

import numpy as np

from modallab.diagnosis.predicting.settings import PREDICTION
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import residual
from modallab.fe.structure import Structure
from modallab.rig.setup import RigSetup


def with_supported_force_noise(structure: Structure, setup: RigSetup, observed: Observed) -> Observed:
    """Return the measurement without free noise of the force where its FRFs contradict that noise.

    Noise of the force lowers the coherence, and H1 with it: so does other noise, of whatever spectrum, which
    lowers the coherence alone. Where no log book declares it, the coherence cannot distinguish them, but the
    FRFs may: by the Cauchy loss of their residuals, which is little changed by a local effect that the model
    lacks.
    """
    levels = observed.free_levels
    if not levels.force_noise:
        return observed
    without = replace(observed, free_levels=replace(levels, force_noise=False))
    losses = [_loss(structure, setup, each) for each in (observed, without)]
    return without if losses[0] - losses[1] > PREDICTION.force_noise_loss else observed


def _loss(structure: Structure, setup: RigSetup, observed: Observed) -> float:
    """Return the Cauchy loss of the FRFs over the number of correlated lines."""
    predicted = SingleTestPredictor.of(structure, setup, observed).predict(())
    squares = np.abs(residual(observed, predicted).frf[observed.fitted]) ** 2
    return float(np.log1p(squares).sum()) / observed.correlation_length
