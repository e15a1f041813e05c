"""Quadratic forms minimised between bounds, for many gradients at once."""

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.diagnosis.optimisation.settings import LEAST_SQUARES


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
        counts = fixed.sum(axis=1)
        n_fixed = int(counts.max())
        few = 2 * counts < n_fixed
        if few.any():  # blocks are as large as the largest: apart, the small ones take an eighth of the time
            steps = np.empty_like(newton)
            for rows in (few, ~few):
                steps[rows] = self._with_fixed(newton[rows], position[rows], fixed[rows])
            return steps
        index = np.argsort(~fixed, axis=1, kind="stable")[:, :n_fixed]
        used = np.take_along_axis(fixed, index, axis=1)
        pairs = used[:, :, None] & used[:, None, :]
        block = np.where(pairs, self._inverse[index[:, :, None], index[:, None, :]], np.eye(n_fixed))
        shift = np.where(used, np.take_along_axis(newton - position, index, axis=1), 0.0)
        forces = np.zeros_like(newton)
        np.put_along_axis(forces, index, np.linalg.solve(block, shift[..., None])[..., 0], axis=1)
        return np.asarray(np.where(fixed, position, newton - forces @ self._inverse))
