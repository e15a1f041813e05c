"""Noise of a force channel that no log book declares: whether the FRFs support it."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray
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
    lacks. Noise makes FRFs lower everywhere; in a model that is a little wrong the loss differs here and
    there, one way and the other, and says nothing unless the difference is beyond that scatter. Nor does an
    FRF that is lower, or higher, by no more than the sensitivity of its accelerometer may be wrong.
    """
    levels = observed.free_levels
    if not levels.force_noise:
        return observed
    without = replace(observed, free_levels=replace(levels, force_noise=False))
    losses = [_losses(structure, setup, each) for each in (observed, without)]
    difference = losses[0] - losses[1]
    by_block = np.array([block.sum() for block in np.array_split(difference, PREDICTION.force_noise_blocks)])
    scatter = float(np.sqrt(np.sum(by_block**2)))
    total = float(by_block.sum())
    contradicts = total > max(PREDICTION.force_noise_loss, PREDICTION.force_noise_scatter * scatter)
    return without if contradicts else observed


def _losses(structure: Structure, setup: RigSetup, observed: Observed) -> FloatArray:
    """Return the Cauchy loss (n_freq,) of the FRFs at each line, over the number of correlated lines.

    Each FRF has the gain of least loss within the error of a sensitivity.
    """
    predicted = SingleTestPredictor.of(structure, setup, observed).predict(())
    error, n = PREDICTION.sensitivity_error, PREDICTION.sensitivities

    def losses(gain: float) -> FloatArray:
        frf = residual(observed, replace(predicted, h=gain * predicted.h)).frf
        return np.log1p(np.where(observed.fitted, np.abs(frf) ** 2, 0.0))

    by_gain = np.array([losses(float(gain)) for gain in np.linspace(1 - error, 1 + error, n)])
    least = by_gain.sum(axis=1).argmin(axis=0)[None, None]
    return np.asarray(np.take_along_axis(by_gain, least, axis=0)[0].sum(axis=1) / observed.correlation_length)
