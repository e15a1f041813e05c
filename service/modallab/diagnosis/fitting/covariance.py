"""Standard errors of fitted parameters, from the derivatives of the residuals."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING, SAFE_SQUARED_DIVISOR
from modallab.diagnosis.fitting.settings import COVARIANCE
from modallab.diagnosis.optimisation.fit_parameters import ParameterVector
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.line_correlation import LineCorrelation
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted, VarianceRatios
from modallab.diagnosis.residuals.residual import Residual, residual
from modallab.rig.effect import Effect, is_nonlinear


@dataclass(frozen=True, eq=False)
class ParameterErrors:
    """Standard errors of the parameters of each effect, and of the nuisance parameters."""

    effects: tuple[dict[str, float], ...]
    """By name of the parameter, in its unit, for each effect; 0 of one that keeps its default."""
    nuisance_covariance: FloatArray
    """(n, n) of the positions of the nuisance parameters, in standard deviations of the prior.

    Zero between a parameter of held-out channels and any other.
    """
    prediction_variance: Mapping[str, float] = field(default_factory=dict)
    """Mean variance of held-out residuals by the errors of fitted parameters, over that of noise, by part."""


class _Correlation(Protocol):
    """Correlation R of residuals."""

    def between(self, columns: FloatArray) -> FloatArray:
        """Return U^T R U of columns (n_data, n)."""


@dataclass(frozen=True)
class _Weighting:
    """Weights of data and prior in a fit."""

    variance: float
    """Mean square of the residuals, at least 1."""
    prior: float
    """Weight of the prior."""


def standard_errors(
    predictor: Predictor, fixed: Sequence[Effect], effects: Sequence[Effect], fitted_residual: Residual
) -> ParameterErrors:
    """Return the standard errors of fitted parameters, each in its unit.

    A parameter on a bound has the error that the data alone give, and does not add to the errors of the
    others; one that the data do not determine has an error as wide as its bounds.

    Parameters
    ----------
    predictor
        Predictor with the nuisance parameters as fitted.
    fitted_residual
        Residual of the fit. Where an effect is missing, its size and not the random error gives the
        variance.
    """
    parameters, nuisances, observed = ParameterVector(effects), predictor.nuisances, predictor.observed
    n = len(parameters)
    if n + len(nuisances) == 0:
        return ParameterErrors(tuple(dict.fromkeys(e.specs(), 0.0) for e in effects), np.zeros((0, 0)), {})
    free, held_out = nuisances.split(observed.outputs, observed.held_out)
    slopes, n_fitted = _derivatives(predictor, fixed, parameters)
    values = zip(parameters.parameters, parameters.values(), strict=True)
    distances = [parameter.distance_to_bound(value) for parameter, value in values]
    room = np.array([*distances, *(nuisances.limits - np.abs(predictor.position))])
    simulated = predictor.simulate_variance([*fixed, *effects])
    weighting, correlation = _weighting(observed, fitted_residual, simulated)
    fitted = np.concatenate([np.arange(n), n + free])
    covariance = _covariance(slopes[:n_fitted, fitted], room[fitted], len(free), weighting, correlation)
    deviations = np.sqrt(np.diag(covariance))
    errors = [dict.fromkeys(effect.specs(), 0.0) for effect in effects]  # of what is not fitted: none
    for parameter, deviation in zip(parameters.parameters, deviations, strict=False):
        width = parameter.spec.upper - parameter.spec.lower
        errors[parameter.effect][parameter.name] = float(min(deviation, width))
    nuisance_covariance = np.zeros((len(nuisances), len(nuisances)))
    nuisance_covariance[np.ix_(free, free)] = covariance[n:, n:]
    if len(held_out):
        held_out_slopes, fitted_slopes = slopes[n_fitted:, n + held_out], slopes[n_fitted:, fitted]
        held_out_covariance = _held_out_covariance(
            held_out_slopes, fitted_slopes, covariance, room[n + held_out], weighting
        )
        nuisance_covariance[np.ix_(held_out, held_out)] = held_out_covariance
    # A parameter on a bound has an error, but no other value was possible in the fit.
    off_bounds = _off_bounds(slopes[:n_fitted, fitted], room[fitted], len(free), weighting)
    propagated = slopes[n_fitted:, fitted] * off_bounds
    variances = ((propagated @ covariance) * propagated).sum(axis=1)
    held_out_lines = (
        fitted_residual.means_by_part(variances, observed.held_out_mask) if len(variances) else {}
    )
    return ParameterErrors(tuple(errors), nuisance_covariance, held_out_lines)


def _held_out_covariance(
    slopes: FloatArray,
    fitted_slopes: FloatArray,
    covariance: FloatArray,
    room: FloatArray,
    weighting: _Weighting,
) -> FloatArray:
    """Return the covariance of nuisance parameters fitted to held-out channels, after all others.

    They compensate the errors of the others, which therefore propagate.
    """
    independent = _Weighting(weighting.variance * weighting.prior, weighting.prior)
    direct = _covariance(slopes, room, slopes.shape[1], independent, None)
    curvature = slopes.T @ slopes + weighting.prior * np.eye(slopes.shape[1])
    propagation = np.linalg.pinv(curvature) @ slopes.T @ fitted_slopes
    return np.asarray(direct + propagation @ covariance @ propagation.T)


def deviating_predictions(
    predictor: Predictor,
    effects: Sequence[Effect],
    predict: Callable[[Sequence[Effect]], Predicted],
) -> Callable[[Sequence[Effect]], Predicted]:
    """Return predictions near some effects for derivatives by nuisance parameters.

    Deviations within tolerances hardly alter the motion at a nonlinear force: it keeps its distortion.

    Parameters
    ----------
    predict
        The predictor's linearisation at these effects.
    """
    return predictor.linearisation_at(effects, same_distortion=True) if is_nonlinear(effects) else predict


def _derivatives(
    predictor: Predictor, fixed: Sequence[Effect], parameters: ParameterVector
) -> tuple[FloatArray, int]:
    """Return derivatives (n_data, n) of residuals by parameters, then by all nuisance parameters.

    Those of fitted lines and channels come first, then held-out ones. The number of the first comes second.
    """
    observed, effects = predictor.observed, [*fixed, *parameters.effects]
    predict = predictor.linearisation_at(effects)
    masks = [observed.fitted, observed.held_out_mask]

    def vector(predicted: Predicted) -> FloatArray:
        whitened = residual(observed, predicted)
        return np.concatenate([whitened.vector(mask) for mask in masks])

    base = predict(effects)
    by_parameters = parameters.physical_derivatives(
        lambda perturbed: vector(predict([*fixed, *perturbed])), vector(base)
    )
    indices = np.arange(len(predictor.nuisances))
    deviating = deviating_predictions(predictor, effects, predict)
    by_nuisances = predictor.nuisances.derivatives(
        lambda deviations: deviating([*deviations, *effects]),
        vector,
        base,
        observed,
        predictor.position,
        indices,
    )
    n_fitted = len(residual(observed, base).vector(observed.fitted))
    return np.hstack([by_parameters, by_nuisances]), n_fitted


def _weighting(
    observed: Observed, fitted_residual: Residual, simulated: VarianceRatios | None
) -> tuple[_Weighting, _Correlation | None]:
    """Return the weights of a fit, and the correlation of its residuals if they are correlated."""
    vector = fitted_residual.vector(observed.fitted)
    tests = None if simulated is None else _simulated_residuals(observed, fitted_residual, simulated)
    mean_square = float(vector @ vector) / len(vector)
    weighting = _Weighting(max(1.0, mean_square), observed.correlation_length)
    correlated = fitted_residual.lines_correlated or observed.correlation_length > 1
    lines = LineCorrelation(fitted_residual, observed.fitted) if correlated else None
    return weighting, lines if tests is None else _BurstCorrelation(lines, tests)


def _simulated_residuals(
    observed: Observed, fitted_residual: Residual, ratios: VarianceRatios
) -> FloatArray | None:
    """Return residuals (n_tests, n_data) of simulated tests with distortion in bursts."""
    if ratios.deviations is None:
        return None
    force, frf, response = ratios.deviations
    variance = observed.incoherent_variance
    no_force = fitted_residual.force is None
    no_response = fitted_residual.response is None
    return np.array(
        [
            replace(
                fitted_residual,
                frf=frf[i] / (np.sqrt(2) * observed.error),
                force=None if no_force else force[i] / np.sqrt(observed.force_variance),
                response=None if no_response or variance is None else response[i] / np.sqrt(variance),
            ).vector(observed.fitted)
            for i in range(len(frf))
        ]
    )


class _BurstCorrelation:
    """Correlation of residuals where a burst of distortion is in many lines and channels at once."""

    def __init__(self, lines: LineCorrelation | None, tests: FloatArray) -> None:
        self._lines, self._tests = lines, tests

    def between(self, columns: FloatArray) -> FloatArray:
        """Return U^T R U of columns (n_data, n): of near lines, or of whole tests where it is larger."""
        lines = columns.T @ columns if self._lines is None else self._lines.between(columns)
        scores = self._tests @ columns
        excess, rotation = np.linalg.eigh(scores.T @ scores / len(scores) - lines)
        return np.asarray(lines + (rotation * np.maximum(excess, 0.0)) @ rotation.T)


def _covariance(
    slopes: FloatArray,
    room: FloatArray,
    n_prior: int,
    weighting: _Weighting,
    correlation: _Correlation | None,
) -> FloatArray:
    """Return the covariance (n, n) of parameters.

    Parameters
    ----------
    slopes
        (n_data, n) derivatives of residuals of unit variance.
    room
        (n,) distance of each parameter to its nearer bound.
    n_prior
        Number of parameters, the last ones, with a prior of unit variance.
    correlation
        Correlation of the residuals; None if they are independent.
    """
    n = slopes.shape[1]
    prior = np.eye(n)[n - n_prior :]
    free = _off_bounds(slopes, room, n_prior, weighting)
    covariance = np.diag(np.diag(_sandwich(slopes, prior, weighting, correlation)))
    covariance[np.ix_(free, free)] = _sandwich(slopes[:, free], prior[:, free], weighting, correlation)
    return covariance


def _off_bounds(slopes: FloatArray, room: FloatArray, n_prior: int, weighting: _Weighting) -> BoolArray:
    """Return which parameters (n,) lie on none of their bounds; arguments as in `_covariance`."""
    n = slopes.shape[1]
    rows = np.vstack([slopes / np.sqrt(weighting.variance * weighting.prior), np.eye(n)[n - n_prior :]])
    return np.asarray(room * np.linalg.norm(rows, axis=0) > COVARIANCE.bound_distance)


def _sandwich(
    slopes: FloatArray, prior: FloatArray, weighting: _Weighting, correlation: _Correlation | None
) -> FloatArray:
    """Return the sandwich covariance A^-1 (v J^T R J + w^2 P) A^-1, A = J^T J + w P.

    Of least squares with weights as if R were 1. A parameter that no residual depends on has the largest
    variance that a double holds.
    """
    jacobian = np.vstack([slopes, np.sqrt(weighting.prior) * prior])
    size = np.maximum(np.linalg.norm(jacobian, axis=0), SAFE_SQUARED_DIVISOR)
    left_vectors, singular, right = np.linalg.svd(jacobian / size, full_matrices=False)
    data, prior_rows = left_vectors[: len(slopes)], left_vectors[len(slopes) :]
    data_product = data.T @ data if correlation is None else correlation.between(data)
    middle = weighting.variance * data_product + weighting.prior * prior_rows.T @ prior_rows
    inverse = right.T / np.maximum(singular, PRODUCT_ROUNDING) / size[:, None]
    return np.asarray(inverse @ middle @ inverse.T)
