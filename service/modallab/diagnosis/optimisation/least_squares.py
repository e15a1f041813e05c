"""Bounded least squares with few evaluations: each is a prediction of a whole measurement."""

from collections.abc import Callable

import numpy as np
import scipy

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.diagnosis.optimisation.settings import DIFFERENCE, LEAST_SQUARES

ResidualFunction = Callable[[FloatArray], FloatArray]
JacobianFunction = Callable[[FloatArray, FloatArray], FloatArray]
"""Derivatives (n_data, n) at a position (n,) with residuals (n_data,)."""


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

    def renew(self) -> None:
        """Compute the derivatives at the position."""
        self.jacobian = self._differentiate(self.position, self.vector)
        self._metric = self.jacobian.T @ self.jacobian
        self.corrections = self._recent_corrections = self._n_partial = 0

    def _renew_some(self) -> None:
        """Compute the first columns of the derivatives, or all where they were renewed often enough."""
        if self._differentiate_first is None or self._n_partial >= self._partial_renewals:
            self.renew()
            return
        columns = self._differentiate_first(self.position, self.vector)
        self.jacobian = np.hstack([columns, self.jacobian[:, columns.shape[1] :]])
        self._metric = self.jacobian.T @ self.jacobian
        self._recent_corrections = 0
        self._n_partial += 1

    def minimise(
        self,
        *,
        evaluations: int,
        tolerance: float,
        excess_share: float = 0.0,
        weights: FloatArray | None = None,
        corrections: int = 1,
        prediction_error: float = 0.0,
        renewals: bool = True,
    ) -> bool:
        """Take steps until one predicts a gain below `tolerance`, in squared standard deviations.

        Returns whether that was so: false after all evaluations, or where derivatives have to be renewed.

        Parameters
        ----------
        evaluations
            Largest number of steps.
        excess_share
            Share of the excess of the cost over that of noise, by which a step has to gain more.
        weights
            (n_data,) of the residuals; all 1 if none are given.
        corrections
            Of the derivatives, at least, before steps that gain slowly renew them.
        prediction_error
            Loss below which two steps in a row that lose end the minimisation.
        renewals
            Whether derivatives may be renewed; if not, the minimisation ends where they would be.
        """
        trust_radius, last_gain, n_lost = LEAST_SQUARES.first_step, np.inf, 0
        for _ in range(evaluations):
            step, predicted_gain = self._step(trust_radius, weights)
            slow = predicted_gain > max(LEAST_SQUARES.slow_gain * last_gain, tolerance)
            if slow and self._recent_corrections >= corrections:
                if not renewals:
                    return False
                self._renew_some()
                step, predicted_gain = self._step(trust_radius, weights)
            last_gain = predicted_gain
            cost = self._cost(self.vector, weights)
            n_data = len(self.vector)
            least_gain = tolerance * max(1.0, cost / n_data) + excess_share * max(cost - n_data, 0)
            if not predicted_gain > least_gain:
                return True
            target = (self.position + step).clip(self._low, self._high)
            vector = self._evaluate(target)
            gain = -np.inf if vector is None else cost - self._cost(vector, weights)
            successful = np.isfinite(gain) and gain > 0
            longest = float(np.abs(step).max())
            # Errors of derivatives promise a gain even at the minimum; those of predictions lose some there.
            n_lost = n_lost + 1 if not successful and gain > -prediction_error else 0
            at_minimum = not self.corrections and (abs(gain) < least_gain or n_lost > 1)
            if vector is not None and successful:
                self._move(target, vector)
                trust_radius = max(trust_radius, LEAST_SQUARES.growth * longest)
            else:
                trust_radius = longest / LEAST_SQUARES.shrinkage
            if at_minimum:
                return True
            if self.corrections and not (successful and gain > LEAST_SQUARES.poor_gain * predicted_gain):
                if not renewals:
                    return False
                if self._recent_corrections:
                    self._renew_some()
                else:
                    self.renew()
        return False

    def _evaluate(self, target: FloatArray) -> FloatArray | None:
        """Return the residuals at a position; None where no prediction exists."""
        try:
            return self._function(target)
        except InvalidInputError:
            return None

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
        step = np.asarray(scipy.optimize.lsq_linear(jacobian, -vector, box, method="bvls").x.clip(low, high))
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


class BoundedQuadratic:
    """A quadratic form d.gradient + d.curvature.d/2, minimised between bounds for many gradients.

    Parameters
    ----------
    curvature
        (n, n), positive definite.
    """

    def __init__(self, curvature: FloatArray) -> None:
        self._curvature = curvature
        self._inverse = np.linalg.inv(curvature)

    def minimise(self, gradient: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return steps d (..., n) between bounds (n,) that reduce the form.

        All at once: Newton's step; where bounds clip it, a few steps of the free parameters. Never worse
        than no step.

        Parameters
        ----------
        gradient
            (..., n).
        low, high
            (n,) bounds of d.
        """
        newton = -(gradient @ self._inverse)
        step = newton.clip(low, high)
        clipped = np.asarray((step != newton).any(axis=-1))
        if clipped.any():
            step[clipped] = self._projected_newton(gradient[clipped], step[clipped], low, high)
        return np.asarray(step)

    def _projected_newton(
        self, gradient: FloatArray, step: FloatArray, low: FloatArray, high: FloatArray
    ) -> FloatArray:
        """Return improved steps (n_steps, n) by projected Newton.

        Parameters whose gradient points out of a bound stay there; Bertsekas, SIAM Journal on Control and
        Optimization 20 (1982), 221, without its line search: the best step is returned.
        """
        newton = -(gradient @ self._inverse)
        best, minimum = np.zeros_like(step), np.zeros(len(step))
        rows = np.arange(len(step))  # of steps that may improve still
        fixed = np.ones(step.shape, bool)
        for _ in range(LEAST_SQUARES.projected_steps):
            slope = gradient[rows] + step @ self._curvature
            value = np.sum(step * (gradient[rows] + slope), axis=-1)
            better = value < minimum[rows]
            best[rows[better]], minimum[rows[better]] = step[better], value[better]
            bound = ((step <= low) & (slope > 0)) | ((step >= high) & (slope < 0))
            other = (bound != fixed).any(axis=1)  # with the same ones fixed the step would repeat itself
            rows, step, fixed = rows[other], step[other], bound[other]
            if not len(rows):
                break
            step = self._with_fixed(newton[rows], step, fixed).clip(low, high)
        return best

    def _with_fixed(self, newton: FloatArray, position: FloatArray, fixed: BoolArray) -> FloatArray:
        """Return the minima (n_steps, n) with some parameters fixed at their positions.

        By the fixed parameters' block of the inverse curvature, which is small where few are fixed, in place
        of the free parameters' block of the curvature.

        Parameters
        ----------
        newton
            (n_steps, n) minima without a fixed parameter.
        """
        n_fixed = int(fixed.sum(axis=1).max())
        index = np.argsort(~fixed, axis=1, kind="stable")[:, :n_fixed]
        used = np.take_along_axis(fixed, index, axis=1)
        pairs = used[:, :, None] & used[:, None, :]
        block = np.where(pairs, self._inverse[index[:, :, None], index[:, None, :]], np.eye(n_fixed))
        shift = np.where(used, np.take_along_axis(newton - position, index, axis=1), 0.0)
        forces = np.zeros_like(newton)
        np.put_along_axis(forces, index, np.linalg.solve(block, shift[..., None])[..., 0], axis=1)
        return np.asarray(np.where(fixed, position, newton - forces @ self._inverse))
