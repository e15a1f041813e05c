"""Nonlinear forces that are in equilibrium with the motions they cause, over a block of time steps."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.rig.local_force import LinearisedForce
from modallab.rig.nonlinear_settings import TIME_STEPPING


class ForceEquilibrium:
    """Solver of the residual forces F = -g(x + response F) at the ends of the steps of a block.

    Parameters
    ----------
    linearised
        By run, of the same laws.
    response
        (n_steps, n_run, r, r) motions at the end of a step and of later ones due to a force at its end.
    """

    def __init__(self, linearised: Sequence[Sequence[LinearisedForce]], response: FloatArray) -> None:
        self._laws = [local.force for local in linearised[0]]
        slopes = np.array([[local.slope for local in run] for run in linearised])
        self._lines = slopes[:, None]  # (n_run, 1, r)
        self._compliance, self._later = response[0], _strictly_lower_toeplitz(response)
        self._n_together = len(response)

    def forces(self, free: FloatArray, last: FloatArray) -> FloatArray:
        """Return the forces (n_steps, n_run, n_records, r), N, of a block.

        A force hardly moves the structure within a block, so that all steps are solved for together. Where
        that does not converge, as where a law bends sharply, from then on half as many at a time are.

        Parameters
        ----------
        free
            (n_steps, n_run, n_records, r) motions without these forces, m or m/s.
        last
            (n_run, n_records, r) forces at the end of the step before, N.
        """
        free, forces = free.copy(), np.empty_like(free)
        start = 0
        while start < len(free):
            end = min(start + self._n_together, len(free))
            found, converged = self._solve_together(free[start:end], last)
            if not converged and end - start > 1:
                self._n_together = (end - start) // 2
                continue
            forces[start:end], last = found, found[-1]
            if end < len(free):
                free[end:] += self._motions(found, end - start, len(free) - start)
            start = end
        return forces

    def _solve_together(self, free: FloatArray, last: FloatArray) -> tuple[FloatArray, bool]:
        """Return the forces of some steps, and whether they converged.

        The Newton steps leave out what each force does to later ones, which the next iteration adds.
        """
        # A spring too steep for a step throws the motion back within it: that diverges, and is refused.
        if len(free) == 1 and len(self._laws) == 1 and self._laws[0].of_velocity:
            return self._force_of_step(free, last), True
        force = np.broadcast_to(last, free.shape)
        for _ in range(TIME_STEPPING.newton_iterations):
            later = self._motions(force, 0, len(free)) if len(free) > 1 else 0.0
            change = self._newton_step(free + later, force)
            force = force + change
            if np.abs(change).max() <= TIME_STEPPING.force_tolerance * np.abs(force).max():
                return force, True
        return force, False

    def _force_of_step(self, free: FloatArray, last: FloatArray) -> FloatArray:
        """Return the force of one law of the velocity at the end of one step, shaped as `free`.

        Newton steps of the velocity between bounds on whose sides the imbalance has opposite signs: where a
        law bends sharply, as friction that sticks, free steps jump from one side to the other for ever. In
        place of one that leaves the bounds, or is no shorter than half the last one, the next one is rest, if
        that lies between the bounds, as friction is steepest there, or halfway. Press et al., Numerical
        Recipes, 3rd ed. (2007), section 9.4.
        """
        law, compliance, line = self._laws[0], self._compliance, self._lines
        x = free + compliance * last
        low, high = np.full(x.shape, -np.inf), np.full(x.shape, np.inf)
        last_size = high
        for _ in range(TIME_STEPPING.bracketed_iterations):
            resistance = law.law(x) - line * x
            imbalance = x - free + compliance * resistance
            step = imbalance / (1 + compliance * (law.slope(x) - line))
            size = np.abs(step)
            too_long = size > TIME_STEPPING.force_tolerance * compliance * np.abs(resistance).max()
            if not too_long.any():
                break
            below = imbalance < 0
            low, high = np.where(below, x, low), np.where(below, high, x)
            new = x - step
            astray = too_long & ((new <= low) | (new >= high) | (size > last_size / 2))
            if astray.any():
                between = np.where((low < 0) & (high > 0), 0.0, (low + high) / 2)
                new = np.where(astray & np.isfinite(between), between, new)
            x, last_size = new, size
        return np.asarray((x - free) / compliance)

    def _motions(self, force: FloatArray, start: int, end: int) -> FloatArray:
        """Return the motions (end - start, ...) from one step to another due to the forces of earlier ones.

        Parameters
        ----------
        force
            (n_steps, n_run, n_records, r) from step 0 on.
        """
        n, n_run, n_records, r = force.shape
        by_run = force.transpose(1, 0, 3, 2).reshape(n_run, n * r, n_records)
        motions = self._later[:, start * r : end * r, : n * r] @ by_run
        return np.asarray(motions.reshape(n_run, end - start, r, n_records).transpose(1, 0, 3, 2))

    def _newton_step(self, free: FloatArray, force: FloatArray) -> FloatArray:
        """Return the Newton step of forces (..., n_run, n_records, r) at motions without them."""
        if len(self._laws) == 1:
            law, compliance, line = self._laws[0], self._compliance, self._lines
            x = free + compliance * force
            imbalance = force + law.law(x) - line * x
            return np.asarray(-imbalance / (1 + compliance * (law.slope(x) - line)))
        x = free + force @ self._compliance.swapaxes(1, 2)
        laws = list(enumerate(self._laws))
        imbalance = force + np.stack([law.law(x[..., i]) for i, law in laws], axis=-1) - self._lines * x
        slope = np.stack([law.slope(x[..., i]) for i, law in laws], axis=-1) - self._lines
        matrix = np.eye(len(laws)) + slope[..., None] * self._compliance[:, None]
        return np.asarray(-np.linalg.solve(matrix, imbalance[..., None])[..., 0])


def _strictly_lower_toeplitz(response: FloatArray) -> FloatArray:
    """Return the matrix (n_run, n_steps r, n_steps r) from forces to the motions of later steps.

    Parameters
    ----------
    response
        (n_steps, n_run, r, r) by the lag between force and motion.
    """
    n, n_run, r, _ = response.shape
    lags = np.subtract.outer(np.arange(n), np.arange(n))
    blocks = np.where(lags[..., None, None, None] > 0, response[lags.clip(0)], 0.0)
    return np.ascontiguousarray(blocks.transpose(2, 0, 3, 1, 4).reshape(n_run, n * r, n * r))
