"""Standard errors of fitted numbers, from how residuals change with them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.optimisation.fit_parameters import ParameterVector
from modallab.diagnosis.optimisation.settings import NUISANCE
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.line_correlation import LineCorrelation
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted, VarianceRatios
from modallab.diagnosis.residuals.residual import Residual, residual
from modallab.rig.effect import Effect

SMALLEST = 1e-100  # derivative
ON_BOUND = 0.01  # standard errors from a bound within which a number lies on it


@dataclass(frozen=True, eq=False)
class ParameterErrors:
    """Standard errors of the numbers of each effect, and of what is tolerated."""

    effects: tuple[dict[str, float], ...]
    nuisance_position: FloatArray  # (n,) standard deviations


class _Together(Protocol):
    """How residuals go together."""

    def between(self, columns: FloatArray) -> FloatArray:
        """Return U^T R U of columns (n_data, n)."""


@dataclass(frozen=True)
class _Weighing:
    """How a fit weighs: by how much its residuals vary more than 1, and the prior's weight."""

    scale: float
    prior: float


def standard_errors(
    predictor: Predictor, fixed: Sequence[Effect], effects: Sequence[Effect], left: Residual
) -> ParameterErrors:
    """Return the standard errors of fitted numbers, each on its own scale.

    A number on a bound is known no better than the data say, and takes no part in the errors of the
    others; one that the data say nothing about has an error as wide as its bounds.

    Parameters
    ----------
    predictor
        With what is tolerated where it was fitted.
    left
        What they leave. Where the fit is not yet right its size says more than the random error does.
    """
    panel, nuisances, observed = ParameterVector(effects), predictor.nuisances, predictor.observed
    n = len(panel)
    if n + len(nuisances) == 0:
        return ParameterErrors(tuple({} for _ in effects), np.zeros(0))
    chosen, own = nuisances.split(observed.outputs, observed.held_out)
    slopes, n_fitted = _slopes(predictor, fixed, panel, with_kept=len(own) > 0)
    room = [
        knob.distance_to_bound(value) for knob, value in zip(panel.parameters, panel.values(), strict=True)
    ]
    rooms = np.array([*room, *(NUISANCE.max_deviation - np.abs(predictor.position))])
    weighing, lines = _weighed(observed, left, predictor.simulate_variance([*fixed, *effects]))
    common = np.concatenate([np.arange(n), n + chosen])
    covariance = _covariance(slopes[:n_fitted, common], rooms[common], len(chosen), weighing, lines)
    spread = np.sqrt(np.diag(covariance))
    errors: list[dict[str, float]] = [{} for _ in effects]
    for knob, one in zip(panel.parameters, spread, strict=False):
        errors[knob.effect][knob.name] = float(min(one, knob.spec.upper - knob.spec.lower))
    tolerated = np.zeros(len(nuisances))
    tolerated[chosen] = spread[n:]
    if len(own):
        mine, rest = slopes[n_fitted:, n + own], slopes[n_fitted:, common]
        apart = _Weighing(weighing.scale * weighing.prior, weighing.prior)
        alone = _covariance(mine, rooms[n + own], len(own), apart, None)
        # They make up for what all others are off.
        carried = np.linalg.pinv(mine.T @ mine + weighing.prior * np.eye(len(own))) @ mine.T @ rest
        tolerated[own] = np.sqrt(np.diag(alone + carried @ covariance @ carried.T))
    return ParameterErrors(tuple(errors), tolerated)


def _slopes(
    predictor: Predictor, fixed: Sequence[Effect], panel: ParameterVector, *, with_kept: bool
) -> tuple[FloatArray, int]:
    """Return derivatives (n_data, n) of residuals by the panel's numbers, then by all that is tolerated.

    Those of fitted lines and channels come first, and how many they are is returned too.
    """
    observed, whole = predictor.observed, [*fixed, *panel.effects]
    sketch = predictor.linearisation_at(whole)

    def vector(predicted: Predicted) -> FloatArray:
        left = residual(observed, predicted)
        return np.concatenate(
            [left.vector(observed.fitted)] + [left.vector(observed.held_out_mask)] * with_kept
        )

    base = sketch(whole)
    here = vector(base)
    own = panel.physical_derivatives(lambda effects: vector(sketch([*fixed, *effects])), here)
    every = np.arange(len(predictor.nuisances))
    also = predictor.nuisances.derivatives(
        lambda more: sketch([*more, *whole]), vector, base, observed, every
    )
    n_fitted = len(residual(observed, base).vector(observed.fitted))
    return np.hstack([own, also]), n_fitted


def _weighed(
    observed: Observed, left: Residual, gone_through: VarianceRatios | None
) -> "tuple[_Weighing, _Together | None]":
    """Return how a fit weighed, and how its lines go together if they do."""
    vector = left.vector(observed.fitted)
    tests = None if gone_through is None else _rehearsed(observed, left, gone_through)
    weighing = _Weighing(max(1.0, float(vector @ vector) / len(vector)), observed.correlation_length)
    mixed = left.lines_correlated or observed.correlation_length > 1
    lines = LineCorrelation(left, observed.fitted) if mixed else None
    return weighing, lines if tests is None else _Bursts(lines, tests)


def _rehearsed(observed: Observed, left: Residual, factors: VarianceRatios) -> FloatArray | None:
    """Return residuals (n_tests, n_data) of tests that were gone through with distortion in bursts."""
    if factors.deviations is None:
        return None
    force, frf, response = factors.deviations
    spread = observed.incoherent_variance
    return np.array(
        [
            replace(
                left,
                frf=frf[i] / (np.sqrt(2) * observed.error),
                force=None if left.force is None else force[i] / np.sqrt(observed.force_variance),
                response=None if left.response is None or spread is None else response[i] / np.sqrt(spread),
            ).vector(observed.fitted)
            for i in range(len(frf))
        ]
    )


class _Bursts:
    """The covariance of residuals where a burst of distortion is in many lines and channels at once."""

    def __init__(self, lines: LineCorrelation | None, tests: FloatArray) -> None:
        self._lines, self._tests = lines, tests

    def between(self, columns: FloatArray) -> FloatArray:
        """Return U^T R U of columns (n_data, n): of near lines, or of whole tests where that is more."""
        own = columns.T @ columns if self._lines is None else self._lines.between(columns)
        seen = self._tests @ columns
        more, turn = np.linalg.eigh(seen.T @ seen / len(seen) - own)
        return np.asarray(own + (turn * np.maximum(more, 0.0)) @ turn.T)


def _covariance(
    slopes: FloatArray,
    room: FloatArray,
    n_prior: int,
    weighing: _Weighing,
    lines: _Together | None,
) -> FloatArray:
    """Return the covariance (n, n) of numbers from derivatives (n_data, n) of residuals of unit variance.

    Parameters
    ----------
    room
        How far each lies from its nearer bound.
    n_prior
        How many of them, the last ones, a prior of unit variance holds.
    lines
        How the residuals of near lines go together; None: not at all.
    """
    n = slopes.shape[1]
    held = np.eye(n)[n - n_prior :]
    error = np.linalg.norm(np.vstack([slopes / np.sqrt(weighing.scale * weighing.prior), held]), axis=0)
    free = room * error > ON_BOUND
    covariance = np.diag(np.diag(_spread(slopes, held, weighing, lines)))
    covariance[np.ix_(free, free)] = _spread(slopes[:, free], held[:, free], weighing, lines)
    return covariance


def _spread(
    slopes: FloatArray, held: FloatArray, weighing: _Weighing, lines: "_Together | None"
) -> FloatArray:
    """Return A^-1 (v J^T R J + w^2 P) A^-1 with A = J^T J + w P, of least squares that weigh as if R were 1.

    Where nothing depends on a number its variance is as large as can be.
    """
    jacobian = np.vstack([slopes, np.sqrt(weighing.prior) * held])
    size = np.maximum(np.linalg.norm(jacobian, axis=0), SMALLEST)
    sides, singular, turn = np.linalg.svd(jacobian / size, full_matrices=False)
    data, prior = sides[: len(slopes)], sides[len(slopes) :]
    middle = weighing.scale * (data.T @ data if lines is None else lines.between(data))
    middle = middle + weighing.prior * prior.T @ prior
    half = turn.T / np.maximum(singular, 1e-12) / size[:, None]
    return np.asarray(half @ middle @ half.T)
