"""Fits the parameters of some effects together on expected spectra, with errors and bounds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import least_squares

from modallab.core.arrays import FloatArray
from modallab.core.parameters import ParameterSpec
from modallab.diagnosis.predictor import Glimpses, Predictor
from modallab.diagnosis.residual import Residual, residual
from modallab.rig.effect import Effect

STEP = 1e-4  # of a logarithm: far above the prediction's rounding, far below any curvature
BLURRED = (0.3, 0.1, 0.03, 0.003)  # widenings a fit passes on its way to none


@dataclass(frozen=True, eq=False)
class Fit:
    """Effects with fitted parameters, and what they leave."""

    effects: tuple[Effect, ...]
    errors: tuple[dict[str, float], ...]  # standard errors, beside `effects`
    residual: Residual
    chi_square: float  # over the fitted lines and channels
    n_parameters: int
    n_data: int

    @property
    def bic(self) -> float:
        """Bayesian information criterion; lower is better."""
        return self.chi_square + self.n_parameters * float(np.log(max(self.n_data, 2)))


@dataclass(frozen=True)
class _Knob:
    """One number of one effect, fitted on a logarithmic scale, or on its own where it may be negative."""

    effect: int
    name: str
    spec: ParameterSpec
    unit: float  # of its own scale: a believable size

    @property
    def bounds(self) -> tuple[float, float]:
        if self.spec.signed:
            return self.spec.lower / self.unit, self.spec.upper / self.unit
        low = max(self.spec.lower, 1e-12 * self.unit)  # upper bounds may lie far beyond what is believable
        return float(np.log(low)), float(np.log(self.spec.upper))

    def position(self, value: float) -> float:
        return value / self.unit if self.spec.signed else float(np.log(max(value, 1e-300)))

    def value(self, position: float) -> float:
        value = position * self.unit if self.spec.signed else np.exp(position)
        return float(np.clip(value, self.spec.lower, self.spec.upper))

    def error(self, spread: float, value: float) -> float:
        """Return the standard error of the number from that of its position."""
        return spread * (self.unit if self.spec.signed else value)


class _Panel:
    """The knobs of some effects, and the effects with the knobs turned."""

    def __init__(self, effects: Sequence[Effect]) -> None:
        self.effects = tuple(effects)
        self.knobs = [
            _Knob(i, name, spec, abs(type(effect)().parameters[name]) or 1.0)
            for i, effect in enumerate(effects)
            for name, spec in effect.specs().items()
        ]
        self.low, self.high = np.array([k.bounds for k in self.knobs]).reshape(-1, 2).T
        start = np.array([k.position(effects[k.effect].parameters[k.name]) for k in self.knobs])
        self.start = start.clip(self.low + 1e-9, self.high - 1e-9)

    def turned(self, u: FloatArray) -> list[Effect]:
        out = list(self.effects)
        for knob, position in zip(self.knobs, u, strict=True):
            out[knob.effect] = out[knob.effect].with_parameters({knob.name: knob.value(float(position))})
        return out


def approach(
    glimpses: Glimpses, fixed: Sequence[Effect], effect: Effect, widening: float
) -> tuple[Effect, float]:
    """Return an effect brought near its best value on first looks, and the cost it has there.

    Least squares with every random error widened, step by step down to the random errors alone: far
    from its goal the objective has many valleys, widened it has one.

    Parameters
    ----------
    widening
        How blurred to begin.
    """
    panel, thin = _Panel([effect]), glimpses.observed

    def vector(u: FloatArray, widen: float) -> FloatArray:
        predicted = glimpses.predict([*fixed, *panel.turned(u)])
        return residual(thin, predicted, widen=widen).vector(thin.fitted)

    u = panel.start
    if not panel.knobs:
        left = vector(u, 0.0)
        return effect, float(left @ left)
    for widen in (*(w for w in BLURRED if w <= widening), 0.0):
        u, _ = _least_squares(partial(vector, widen=widen), u, (panel.low, panel.high), evaluations=4)
    left = vector(u, 0.0)
    return panel.turned(u)[0], float(left @ left)


def fit(predictor: Predictor, effects: Sequence[Effect], *, fixed: Sequence[Effect] = ()) -> Fit:
    """Return the effects with all their parameters fitted together, from starts near their goal.

    Bounded trust-region least squares on logarithmic ratios, `scipy.optimize.least_squares`.

    Parameters
    ----------
    fixed
        Effects that act but are not fitted.
    """
    panel, where = _Panel(effects), predictor.observed.fitted
    jacobian = np.zeros((1, 0))
    final = list(effects)
    if panel.knobs:
        u, jacobian = _least_squares(
            lambda u: predictor.residual([*fixed, *panel.turned(u)]).vector(where),
            panel.start,
            (panel.low, panel.high),
            evaluations=12,
        )
        final = panel.turned(u)
    left = predictor.residual([*fixed, *final])
    vector = left.vector(where)
    chi_square = float(vector @ vector)
    # Where the fit is not yet right the residuals' own size says more than the random error does.
    scale = predictor.observed.correlation * max(1.0, chi_square / len(vector))
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * scale
    errors: list[dict[str, float]] = [{} for _ in effects]
    for i, knob in enumerate(panel.knobs):
        spread = float(np.sqrt(covariance[i, i]))
        errors[knob.effect][knob.name] = knob.error(spread, final[knob.effect].parameters[knob.name])
    return Fit(tuple(final), tuple(errors), left, chi_square, len(panel.knobs), len(vector))


def _least_squares(
    function: Callable[[FloatArray], FloatArray],
    start: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    *,
    evaluations: int,
) -> tuple[FloatArray, FloatArray]:
    """Return the best point and the Jacobian there."""

    known: dict[bytes, FloatArray] = {}

    def once(u: FloatArray) -> FloatArray:
        if u.tobytes() not in known:
            known.clear()  # only the last point is asked for again, by the Jacobian
            known[u.tobytes()] = function(u)
        return known[u.tobytes()]

    def jacobian(u: FloatArray) -> FloatArray:
        here = once(u)
        columns = []
        for i in range(len(u)):
            step = np.zeros(len(u))
            step[i] = STEP if u[i] + STEP < bounds[1][i] else -STEP
            columns.append((function(u + step) - here) / step[i])
        return np.array(columns).T

    inside = np.clip(start, bounds[0] + 1e-9, bounds[1] - 1e-9)
    found = least_squares(
        once, inside, jac=jacobian, bounds=bounds, max_nfev=evaluations, xtol=1e-6, ftol=1e-6, gtol=1e-12
    )
    return found.x, found.jac
