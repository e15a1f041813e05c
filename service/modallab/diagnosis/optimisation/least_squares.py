"""Bounded least squares with few evaluations: each is a prediction of a whole measurement."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.diagnosis.optimisation.bounded_least_squares import bounded_least_squares
from modallab.diagnosis.optimisation.settings import DIFFERENCE, LEAST_SQUARES

ResidualFunction = Callable[[FloatArray], FloatArray]
JacobianFunction = Callable[[FloatArray, FloatArray], FloatArray]
"""Derivatives (n_data, n) at a position (n,) with residuals (n_data,)."""


@dataclass(frozen=True)
class StepRules:
    """When the steps of a minimisation end, and when they renew derivatives."""

    evaluations: int
    """Largest number of steps."""
    tolerance: float
    """Gain below which a step is not taken, in squared standard deviations."""
    excess_share: float = 0.0
    """Share of the excess of the cost over that of noise, by which a step has to gain more."""
    goal: float = 0.0
    """Cost below which the minimisation ends."""
    prediction_error: float = 0.0
    """Error of the cost by that of predictions. Two steps in a row that lose less end the minimisation;
    derivatives whose steps gained less are not renewed. 0 where residuals have weights."""
    corrections: int = 1
    """Steps with corrected derivatives, at least, before one that gains slowly renews them."""
    poor_steps: int = 0
    """Steps in a row that may gain little or nothing before corrected derivatives are renewed."""
    renewals: bool = True
    """Whether derivatives may be renewed; if not, the minimisation ends where they would be."""
    partial_renewals: bool = True
    """Whether the first columns may be renewed alone. They do not match the corrected ones: near the
    minimum, where columns nearly cancel, steps by such derivatives go astray."""


class BoundedGaussNewton:
    """Minimisation of a sum of squares between bounds.

    Gauss-Newton steps in a box that is the trust region and keeps the bounds, so that a parameter can end
    on one: Stark and Parker, Bounded-variable least squares, Computational Statistics 10 (1995). Derivatives
    cost an evaluation per parameter; between two of them each step corrects the Jacobian by the residuals it
    found: Broyden, Mathematics of Computation 19 (1965), 577, with step lengths measured in residuals. Where
    the first few parameters can be differentiated alone, most renewals are of their columns.

    Parameters
    ----------
    differentiate_first
        Derivatives (n_data, k) by the first k parameters alone; None: always by all.
    partial_renewals
        Renewals of the first columns between two renewals of all.
    """

    def __init__(
        self,
        function: ResidualFunction,
        differentiate: JacobianFunction,
        start: FloatArray,
        bounds: tuple[FloatArray, FloatArray],
        *,
        differentiate_first: JacobianFunction | None = None,
        partial_renewals: int = 0,
    ) -> None:
        self._function, self._differentiate = function, differentiate
        self._differentiate_first, self._partial_renewals = differentiate_first, partial_renewals
        self._low, self._high = bounds
        self.position = start.clip(*bounds)
        self.vector = function(self.position)
        self.renew()

    @property
    def cost(self) -> float:
        """Sum of squares of the residuals at the position, without weights."""
        return self._cost(self.vector, None)

    def renew(self) -> None:
        """Compute the derivatives at the position."""
        self.jacobian = self._differentiate(self.position, self.vector)
        self._metric = self.jacobian.T @ self.jacobian
        self.corrections = self._recent_corrections = self._n_partial = 0
        self._cost_at_renewal = self.cost

    def _renew(self, partial: bool) -> None:
        """Compute the first columns of the derivatives, or all where they were renewed often enough."""
        if not partial or self._differentiate_first is None or self._n_partial >= self._partial_renewals:
            self.renew()
            return
        columns = self._differentiate_first(self.position, self.vector)
        self.jacobian = np.hstack([columns, self.jacobian[:, columns.shape[1] :]])
        self._metric = self.jacobian.T @ self.jacobian
        self._recent_corrections = 0
        self._n_partial += 1

    def minimise(self, rules: StepRules, weights: FloatArray | None = None) -> bool:
        """Take steps until one predicts a gain below the tolerance of the rules.

        Returns whether that was so: false after all evaluations, at the goal, or where derivatives have to be
        renewed.

        Parameters
        ----------
        weights
            (n_data,) of the residuals; all 1 if none are given.
        """
        trust_radius, last_gain, n_lost, n_poor = LEAST_SQUARES.first_step, np.inf, 0, 0
        for _ in range(rules.evaluations):
            step, predicted_gain = self._step(trust_radius, weights)
            slow = predicted_gain > max(LEAST_SQUARES.slow_gain * last_gain, rules.tolerance)
            if slow and self._recent_corrections >= rules.corrections:
                if not rules.renewals:
                    return False
                self._renew(rules.partial_renewals)
                step, predicted_gain = self._step(trust_radius, weights)
            last_gain = predicted_gain
            cost, n_data = self._cost(self.vector, weights), len(self.vector)
            excess = max(cost - n_data, 0)
            least_gain = rules.tolerance * max(1.0, cost / n_data) + rules.excess_share * excess
            if not predicted_gain > least_gain:
                return True
            corrected, longest = self.corrections > 0, float(np.abs(step).max())
            gain = self._try(step, cost, weights)
            # Errors of derivatives promise a gain even at the minimum; those of predictions lose some there.
            n_lost = n_lost + 1 if -rules.prediction_error < gain <= 0 else 0
            if not corrected and (abs(gain) < least_gain or n_lost > 1):
                return True
            if gain > 0:
                trust_radius = max(trust_radius, LEAST_SQUARES.growth * longest)
            else:
                trust_radius = longest / LEAST_SQUARES.shrinkage
            poor = self.corrections > 0 and gain <= LEAST_SQUARES.poor_gain * predicted_gain
            n_poor = n_poor + 1 if poor else 0
            if n_poor > rules.poor_steps:
                gained = self._cost_at_renewal - self.cost
                no_gain = rules.prediction_error > 0 and gained < rules.prediction_error
                if not rules.renewals or no_gain:
                    return rules.renewals
                n_poor = 0
                self._renew(rules.partial_renewals and self._recent_corrections > 0)
                if not self.corrections:  # the derivatives were wrong, not the step too long
                    trust_radius = max(trust_radius, LEAST_SQUARES.first_step)
            if cost - gain < rules.goal:
                return False
        return False

    def _try(self, step: FloatArray, cost: float, weights: FloatArray | None) -> float:
        """Return what a step gains, and take it if it does; -inf where no prediction exists.

        Parameters
        ----------
        cost
            Cost before the step.
        """
        target = (self.position + step).clip(self._low, self._high)
        try:
            vector = self._function(target)
        except InvalidInputError:
            return -np.inf
        gain = cost - self._cost(vector, weights)
        if not np.isfinite(gain):
            return -np.inf
        if gain > 0:
            self._move(target, vector)
        return gain

    def _move(self, target: FloatArray, vector: FloatArray) -> None:
        step = target - self.position
        deviation = vector - self.vector - self.jacobian @ step
        direction = self._metric @ step
        if (length := float(step @ direction)) > 0:
            self.jacobian = self.jacobian + np.outer(deviation, direction / length)
        self.position = target
        self.vector = vector
        self.corrections += 1
        self._recent_corrections += 1

    def _step(self, trust_radius: float, weights: FloatArray | None) -> tuple[FloatArray, float]:
        """Return the best step within bounds and trust region, and its predicted gain."""
        system = np.column_stack([self.jacobian, self.vector])
        if weights is not None:
            system *= weights[:, None]
        triangle = _triangle(system)
        jacobian, vector = triangle[:, :-1], triangle[:, -1]
        low = np.maximum(self._low - self.position, -trust_radius)
        high = np.minimum(self._high - self.position, trust_radius)
        # A parameter on its bound still needs a box that is not empty.
        box = low, np.maximum(high, low + PRODUCT_ROUNDING)
        step = bounded_least_squares(jacobian, -vector, box).clip(low, high)
        return step, float(vector @ vector - np.sum((vector + jacobian @ step) ** 2))

    @staticmethod
    def _cost(vector: FloatArray, weights: FloatArray | None) -> float:
        return float(vector @ vector) if weights is None else float(np.sum((weights * vector) ** 2))


def _triangle(system: FloatArray) -> FloatArray:
    """Return the triangular factor R (n, n) of a QR decomposition, rows up to their signs.

    By a Cholesky decomposition of the products of unit columns, which takes a fifth of the time; where
    columns are nearly dependent, so that the products lose digits, by Householder reflections.

    Parameters
    ----------
    system
        (n_data, n).
    """
    lengths = np.linalg.norm(system, axis=0)
    lengths[lengths == 0] = 1.0
    unit = system / lengths
    try:
        triangle = np.linalg.cholesky(unit.T @ unit).T
        independent = bool(np.diag(triangle).min() > LEAST_SQUARES.least_independence)
    except np.linalg.LinAlgError:
        independent = False
    if not independent:
        triangle = np.asarray(np.linalg.qr(unit, mode="r"))
    return np.asarray(triangle * lengths)


def finite_difference(
    shifted: Callable[[float], FloatArray], base: FloatArray, step: float, max_step: float
) -> FloatArray:
    """Return the derivative (n_data,) of residuals by one parameter.

    The difference over a small step; but where residuals are flat and curved over one standard error, the
    difference over the step that changes them by about one standard deviation. A fit would otherwise move
    such a parameter far, and shrink its trust region when that proves wrong.

    Parameters
    ----------
    shifted
        Residuals at a shift of the parameter.
    base
        Residuals without a shift.
    step
        Small step; its sign is the side of the difference.
    max_step
        Size of the longest step.
    """
    change = shifted(step) - base
    size = float(np.linalg.norm(change))
    if not 0 < size < DIFFERENCE.linear_change:
        return np.asarray(change / step)
    long_step = float(np.copysign(max(min(abs(step) / size, max_step), abs(step)), step))
    long_change = shifted(long_step) - base
    if float(np.linalg.norm(long_change)) < DIFFERENCE.linearity:
        return np.asarray(change / step)
    for _ in range(DIFFERENCE.max_refinements):
        long_step /= np.sqrt(np.linalg.norm(long_change))
        long_change = shifted(long_step) - base
        if 1 / DIFFERENCE.linearity < np.linalg.norm(long_change) < DIFFERENCE.linearity:
            break
    return np.asarray(long_change / long_step)
