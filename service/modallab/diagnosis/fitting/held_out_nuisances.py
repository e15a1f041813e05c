"""What belongs to a held-out channel alone, read off that channel."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import lsq_linear

from modallab.core.arrays import FloatArray, IntArray
from modallab.diagnosis.optimisation.settings import NUISANCE
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.residual import Residual, residual
from modallab.rig.effect import Effect


def fit_held_out_nuisances(
    predictor: Predictor, effects: Sequence[Effect], left: Residual, own: IntArray
) -> FloatArray:
    """Return the position of all that is tolerated, what belongs to held-out channels read off them.

    A channel's own sensitivity and delay are seen nowhere else. The logarithm of an FRF is a straight
    line in both, so that one step is enough.

    Parameters
    ----------
    left
        Of the effects, with all else where it was fitted.
    own
        Which of all belong to channels held out.
    """
    observed, position = predictor.observed, predictor.position.copy()
    where = observed.held_out_mask
    sketch = predictor.linearisation_at(effects)

    def vector(predicted: Predicted) -> FloatArray:
        return residual(observed, predicted).vector(where)

    slopes = predictor.nuisances.derivatives(
        lambda more: sketch([*more, *effects]), vector, sketch(effects), observed, own
    )
    prior = np.sqrt(observed.correlation_length) * np.eye(len(own))
    rows = np.vstack([slopes, prior])
    target = -np.concatenate([left.vector(where), prior @ position[own]])
    bounds = (-NUISANCE.max_deviation - 1e-9 - position[own], NUISANCE.max_deviation + 1e-9 - position[own])
    position[own] += lsq_linear(rows, target, bounds, method="bvls").x
    return position.clip(-NUISANCE.max_deviation, NUISANCE.max_deviation)
