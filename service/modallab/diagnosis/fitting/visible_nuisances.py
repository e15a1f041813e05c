"""Nuisance parameters of modes above the band: those that a test shows."""

from modallab.core.arrays import FloatArray
from modallab.diagnosis.optimisation.settings import NUISANCE
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.residual import residual


def with_visible_nuisances(predictor: SingleTestPredictor) -> SingleTestPredictor:
    """Return the predictor without the parameters of modes above the band that its test does not show.

    Where noise is low the loss factor of a mode at twice the top of the band is seen near antiresonances.
    """
    nuisances, observed = predictor.nuisances, predictor.observed
    above = nuisances.above_band
    if not len(above):
        return predictor
    predict = predictor.linearisation_at(())

    def vector(predicted: Predicted) -> FloatArray:
        return residual(observed, predicted).vector(observed.fitted)

    columns = nuisances.derivatives(predict, vector, predict(()), observed, predictor.position, above)
    least = NUISANCE.least_visibility * observed.correlation_length
    invisible = above[(columns**2).sum(axis=0) < least]
    return predictor.with_nuisances(nuisances.without(invisible))
