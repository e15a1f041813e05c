"""Nonlinear forces in time: what they leave of their straight lines, found step by step."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from modallab.core.arrays import FloatArray
from modallab.rig.local_force import Linearised

NEWTON = 4  # steps to the force at the end of a time step: the motion hardly feels it within one


@dataclass(frozen=True, eq=False)
class Feedback:
    """How a structure with passive sources answers forces at some motions: a sum of real modes.

    Loss factors count as viscous damping of half their size, which is exact at resonance: the force
    that is fed back here is what a straight line leaves, small against the force itself.
    """

    shapes: FloatArray  # (r, m) of the motions, 1/sqrt(kg)
    omega: FloatArray  # (m,) rad/s
    loss_factor: FloatArray  # (m,)


class Stepper:
    """Steps modes through time exactly for forces that run in straight lines from step to step."""

    def __init__(self, feedback: Feedback, step: float) -> None:
        self.shapes = feedback.shapes
        exact = [_step(w, eta, step) for w, eta in zip(feedback.omega, feedback.loss_factor, strict=True)]
        self._turn = np.array([one[:, :2] for one in exact])  # (m, 2, 2)
        self._old = np.array([one[:, 2] for one in exact])  # (m, 2) of the force before
        self._new = np.array([one[:, 3] for one in exact])
        # What a force at the end of a step does within it, (r, r, 2): displacement and velocity.
        self.at_once = np.einsum("am,bm,mk->abk", self.shapes, self.shapes, self._new)

    def rest(self, n: int) -> FloatArray:
        """Return modes at rest, (n, m, 2)."""
        return np.zeros((n, self.shapes.shape[1], 2))

    def carried(self, state: FloatArray, force: FloatArray) -> FloatArray:
        """Return the modes (n, m, 2) one step on under the old force (n, r) alone."""
        moved = np.einsum("mjk,nmk->nmj", self._turn, state)
        return np.asarray(moved + (force @ self.shapes)[:, :, None] * self._old)

    def pushed(self, state: FloatArray, force: FloatArray) -> FloatArray:
        """Return the carried modes with the new force (n, r) on them."""
        return np.asarray(state + (force @ self.shapes)[:, :, None] * self._new)


def _step(omega: float, loss_factor: float, step: float) -> FloatArray:
    """Return what displacement and velocity are a step on, of both, old and new force, (2, 4)."""
    a = np.zeros((4, 4))
    a[0, 1], a[1, 0], a[1, 1] = 1.0, -(omega**2), -loss_factor * omega
    a[1, 2], a[2, 3] = 1.0, 1.0 / step  # force u, rising at (new - old)/step
    whole = expm(a * step)[:2]
    return np.column_stack([whole[:, :2], whole[:, 2] - whole[:, 3], whole[:, 3]])


def residual_forces(
    found: Sequence[Linearised], moved: FloatArray, velocity: FloatArray, stepper: Stepper
) -> FloatArray:
    """Return the residual of every local force over time, (n, r, n_samples) N.

    The motion is what the sources alone cause in the linearised structure plus what the residuals
    themselves cause, from rest; at the end of each step the force there is found by Newton's method.

    Parameters
    ----------
    moved, velocity
        (n, r, n_samples) m and m/s at the local forces, of the linearised structure, for records that
        are stepped side by side.
    """
    n, r, n_samples = moved.shape
    out = np.zeros((n, r, n_samples))
    state, force = stepper.rest(n), np.zeros((n, r))
    which = [int(one.force.of_velocity) for one in found]
    own = np.array([[stepper.at_once[a, b, which[a]] for b in range(r)] for a in range(r)])
    given = np.stack([(moved, velocity)[kind][:, i] for i, kind in enumerate(which)], axis=1)
    for t in range(n_samples):
        state = stepper.carried(state, force)
        fed = np.stack([state[:, :, kind] @ stepper.shapes[i] for i, kind in enumerate(which)], axis=1)
        force = _balanced(found, given[:, :, t] + fed, own, force)
        state = stepper.pushed(state, force)
        out[:, :, t] = -force
    return out


def _balanced(
    found: Sequence[Linearised], free: FloatArray, own: FloatArray, guess: FloatArray
) -> FloatArray:
    """Return the forces on the structure (n, r) that agree with their motion: F = -g(free + own F)."""
    force = guess
    for _ in range(NEWTON):
        x = free + force @ own.T
        left = force + np.stack([one.residual(x[:, i]) for i, one in enumerate(found)], axis=1)
        slope = np.stack([one.residual_slope(x[:, i]) for i, one in enumerate(found)], axis=1)
        if len(found) == 1:
            force = force - left / (1 + slope * own)
        else:
            matrix = np.eye(len(found)) + slope[:, :, None] * own
            force = force - np.linalg.solve(matrix, left[:, :, None])[:, :, 0]
    return force
