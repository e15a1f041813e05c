"""Nuisance parameters of modes above the band and of small shapes: those that a test shows."""

from modallab.core.arrays import FloatArray
from modallab.diagnosis.optimisation.settings import NUISANCE
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.residual import residual


def with_visible_nuisances(predictor: SingleTestPredictor) -> SingleTestPredictor:
    """Return the predictor without the optional nuisance parameters that its test does not show.

    Where noise is low the loss factor of a mode at twice the top of the band is seen near antiresonances, and
    a deviation of some members by a hundred-thousandth near resonances. A parameter that held-out FRFs alone
    show is kept: its prior is a part of their prediction's variance.
    """
    nuisances, observed = predictor.nuisances, predictor.observed
    optional = nuisances.optional
    if not len(optional):
        return predictor
    predict = predictor.linearisation_at(())

    def vector(predicted: Predicted) -> FloatArray:
        return residual(observed, predicted).vector(observed.usable)

    columns = nuisances.derivatives(predict, vector, predict(()), observed, predictor.position, optional)
    least = NUISANCE.least_visibility * observed.correlation_length
    invisible = optional[(columns**2).sum(axis=0) < least]
    return predictor.with_nuisances(nuisances.without(invisible))
