"""Nuisance parameters that only held-out channels determine."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.diagnosis.optimisation.bounded_least_squares import bounded_least_squares
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.residual import Residual, residual
from modallab.rig.effect import Effect


def fit_held_out_nuisances(
    predictor: Predictor, effects: Sequence[Effect], fitted_residual: Residual, indices: IntArray
) -> FloatArray:
    """Return the position (n,) of all nuisance parameters, those of held-out channels fitted to them.

    A channel's sensitivity and delay act on its own FRF alone. The logarithm of an FRF is linear in both,
    so that one step is enough.

    Parameters
    ----------
    fitted_residual
        Residual of the effects, with all other parameters as fitted.
    indices
        Indices of the parameters that belong to held-out channels.
    """
    observed, position = predictor.observed, predictor.position.copy()
    mask = observed.held_out_mask
    predict = predictor.linearisation_at(effects)

    def vector(predicted: Predicted) -> FloatArray:
        return residual(observed, predicted).vector(mask)

    derivatives = predictor.nuisances.derivatives(
        lambda deviations: predict([*deviations, *effects]),
        vector,
        predict(effects),
        observed,
        position,
        indices,
    )
    prior = np.sqrt(observed.correlation_length) * np.eye(len(indices))
    rows = np.vstack([derivatives, prior])
    target = -np.concatenate([fitted_residual.vector(mask), prior @ position[indices]])
    limits = predictor.nuisances.limits
    reach = limits[indices] + COMPARISON_ROUNDING
    bounds = -reach - position[indices], reach - position[indices]
    position[indices] += bounded_least_squares(rows, target, bounds)
    return position.clip(-limits, limits)
