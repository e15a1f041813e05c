"""Bounded least squares that asks for few evaluations: each is a prediction of a whole measurement."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import lsq_linear

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError

REACH = 1.0  # of a first step in any coordinate
POOR = 0.25  # share of the promised gain below which derivatives are taken anew
ROUNDS = 5  # of which the last is only looked for, the first the cut one
PLAIN = 0.1  # of a random error: change over a small step that needs no second look
STRAIGHT = 2.0  # times what a slope promises that residuals change by at most
NEARER = 6  # tries to find the step that changes them by about one random error
SLOW = 0.1  # share of the last promise above which the next says that they are no longer right

Function = Callable[[FloatArray], FloatArray]
Slopes = Callable[[FloatArray, FloatArray], FloatArray]  # of a position and the residuals there


class Descent:
    """A sum of squares on its way down, between bounds.

    Gauss-Newton steps in a box that is the trust region and keeps the bounds, so that a number can come
    to lie on one: Stark and Parker, Bounded-variable least squares, Computational Statistics 10 (1995).
    Between derivatives, which cost an evaluation a number, each step corrects them by what it showed:
    Broyden, Mathematics of Computation 19 (1965), 577, with lengths of steps taken in residuals.
    """

    def __init__(
        self,
        function: Function,
        differentiate: Slopes,
        start: FloatArray,
        bounds: tuple[FloatArray, FloatArray],
    ) -> None:
        self._function, self._differentiate = function, differentiate
        self._low, self._high = bounds
        self.position = start.clip(*bounds)
        self.vector = function(self.position)
        self._renew()

    def _renew(self) -> None:
        self.jacobian = self._differentiate(self.position, self.vector)
        self._metric = self.jacobian.T @ self.jacobian
        self._fresh = True

    def go(self, *, evaluations: int, enough: float, weights: FloatArray | None = None) -> None:
        """Go down until a step promises no more than `enough` of a squared random error.

        Parameters
        ----------
        weights
            (n_data,) of the residuals; all 1 if none are given.
        """
        reach, before = REACH, np.inf
        for _ in range(evaluations):
            step, promised = self._step(reach, weights)
            if not self._fresh and promised > max(SLOW * before, enough):
                self._renew()
                step, promised = self._step(reach, weights)
            before = promised
            cost = self._cost(self.vector, weights)
            if not promised > enough * max(1.0, cost / len(self.vector)):
                return
            target = (self.position + step).clip(self._low, self._high)
            there = self._tried(target)
            gained = -np.inf if there is None else cost - self._cost(there, weights)
            good = np.isfinite(gained) and gained > 0
            if there is not None and good:
                self._move(target, there)
                reach = max(reach, 2 * float(np.abs(step).max()))
            else:
                reach = float(np.abs(step).max()) / 4
            if not self._fresh and not (good and gained > POOR * promised):
                self._renew()

    def _tried(self, target: FloatArray) -> FloatArray | None:
        """Return the residuals there; None where nothing can be predicted."""
        try:
            return self._function(target)
        except InvalidInputError:
            return None

    def _move(self, target: FloatArray, there: FloatArray) -> None:
        step = target - self.position
        missed = there - self.vector - self.jacobian @ step
        along = self._metric @ step
        if (length := float(step @ along)) > 0:
            self.jacobian = self.jacobian + np.outer(missed, along / length)
        self.position = target
        self.vector, self._fresh = there, False

    def _step(self, reach: float, weights: FloatArray | None) -> tuple[FloatArray, float]:
        """Return the best step within bounds and reach, and how much the sum of squares should fall."""
        both = np.column_stack([self.jacobian, self.vector])
        if weights is not None:
            both *= weights[:, None]
        triangle = np.asarray(np.linalg.qr(both, mode="r"))
        finite_difference, left = triangle[:, :-1], triangle[:, -1]
        low = np.maximum(self._low - self.position, -reach)
        high = np.minimum(self._high - self.position, reach)
        # A number on its bound still needs a box that is not empty.
        step = lsq_linear(finite_difference, -left, (low, np.maximum(high, low + 1e-12)), method="bvls").x
        step = np.asarray(step.clip(low, high))
        return step, float(left @ left - np.sum((left + finite_difference @ step) ** 2))

    @staticmethod
    def _cost(vector: FloatArray, weights: FloatArray | None) -> float:
        return float(vector @ vector) if weights is None else float(np.sum((weights * vector) ** 2))


def finite_difference(
    moved: Callable[[float], FloatArray], here: FloatArray, step: float, most: float
) -> FloatArray:
    """Return how residuals change with one number, (n_data,) a unit.

    The difference over a small step; but where residuals are flat and curved, which shows one standard
    error away, over the step that changes them by about one random error. A fit would else let such a
    number loose, and trust nothing when that proves wrong.

    Parameters
    ----------
    moved
        Residuals so far aside.
    step
        Small; its sign is the side that is looked at.
    most
        Size of the largest step that is looked at.
    """
    change = moved(step) - here
    size = float(np.linalg.norm(change))
    if not 0 < size < PLAIN:
        return np.asarray(change / step)
    far = float(np.copysign(max(min(abs(step) / size, most), abs(step)), step))
    seen = moved(far) - here
    if float(np.linalg.norm(seen)) < STRAIGHT:
        return np.asarray(change / step)
    for _ in range(NEARER):
        far /= np.sqrt(np.linalg.norm(seen))
        seen = moved(far) - here
        if 1 / STRAIGHT < np.linalg.norm(seen) < STRAIGHT:
            break
    return np.asarray(seen / far)


class Curvature:
    """Of a function d.pull + d.curvature.d/2 whose least value is looked for between bounds, many times.

    Parameters
    ----------
    curvature
        (n, n), positive definite.
    """

    def __init__(self, curvature: FloatArray) -> None:
        self._curvature = curvature
        self._inverse = np.linalg.inv(curvature)

    def boxed(self, pull: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return steps d (..., n) between bounds (n,) that make the function small.

        For many at once: Newton's step; where bounds cut it, a few more of the numbers that are free.
        Never worse than no step.

        Parameters
        ----------
        pull
            (..., n).
        """
        newton = -(pull @ self._inverse)
        step = newton.clip(low, high)
        cut = np.asarray((step != newton).any(axis=-1))
        if cut.any():
            step[cut] = self._held(pull[cut], step[cut], low, high)
        return np.asarray(step)

    def _held(self, pull: FloatArray, step: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return better steps (n_steps, n) than those cut at the bounds: by Newton's projected step.

        Numbers that are pulled against a bound stay there; Bertsekas, SIAM Journal on Control and
        Optimization 20 (1982), 221, without its search along the line: the best step seen is kept.
        """
        best, least, alone = np.zeros_like(step), np.zeros(len(step)), np.eye(step.shape[1])
        for _ in range(ROUNDS):
            finite_difference = pull + step @ self._curvature
            value = np.sum(step * (pull + finite_difference), axis=-1)
            better = value < least
            best[better], least[better] = step[better], value[better]
            free = ~(((step <= low) & (finite_difference > 0)) | ((step >= high) & (finite_difference < 0)))
            both = free[:, :, None] & free[:, None, :]
            rest = np.where(free, finite_difference, 0.0)[..., None]
            newton = np.linalg.solve(np.where(both, self._curvature, alone), rest)[..., 0]
            step = (step - newton).clip(low, high)
        return best
