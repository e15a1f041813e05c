"""Nonlinear forces in time: what they leave of their straight lines, found step by step."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import DivergedError
from modallab.fe.system import DynamicSystem
from modallab.rig.local_force import Linearised

STILL = 1e-3  # rad/s: what moves slower is a rigid body
NEWTON = 2  # steps to the force at the end of a time step: the motion hardly feels it within one


@dataclass(frozen=True, eq=False)
class Feedback:
    """How a structure with passive sources answers forces at some motions: a sum of real modes.

    Structural damping counts as viscous damping of the same width, which is exact at resonance: the
    force that is fed back here is what a straight line leaves, small against the force itself.
    """

    shapes: FloatArray  # (r, m) of the motions, 1/sqrt(kg)
    omega: FloatArray  # (m,) rad/s
    damping: FloatArray  # (m,) 1/s, twice the rate of decay

    @classmethod
    def of(cls, system: DynamicSystem, dofs: tuple[Dof, ...]) -> "Feedback":
        """Return the modes of a system at some DoFs."""
        basis = system.modes()
        columns = system.selection(dofs)
        shapes = columns.T @ basis.shapes[: len(columns)].real
        omega = 2 * np.pi * basis.frequencies
        lost = basis.eigenvalues.imag
        damping = np.divide(lost, omega, out=np.zeros_like(omega), where=omega > STILL)
        if basis.viscous is not None:
            damping = damping + np.diag(basis.viscous).real
        heard = np.abs(shapes).max(axis=0) > 1e-9 * np.abs(shapes).max()
        return cls(shapes[:, heard], omega[heard], damping[heard])


class Stepper:
    """Steps modes through time exactly for forces that run in straight lines from step to step.

    A state (n, 2 m + r) holds displacements and velocities of the modes and the last forces: a step
    is one matrix product.
    """

    def __init__(self, feedback: Feedback, step: float) -> None:
        self.shapes = shapes = feedback.shapes
        r, m = shapes.shape
        exact = np.array([_step(w, c, step) for w, c in zip(feedback.omega, feedback.damping, strict=True)])
        turn = np.zeros((2 * m + r, 2 * m + r))
        mode = np.arange(m)
        for new in range(2):
            for old in range(2):
                turn[old * m + mode, new * m + mode] = exact[:, new, old]
            turn[2 * m :, new * m : (new + 1) * m] = shapes * exact[:, new, 2]
        self.turn = turn
        self.push = np.hstack([shapes * exact[:, 0, 3], shapes * exact[:, 1, 3], np.eye(r)])
        nothing = np.zeros((r, m))
        own = np.zeros((r, r))
        # What each motion is of a state, (2 m + r, r): its displacement or its velocity.
        self.reading = np.stack(
            [np.vstack([shapes.T, nothing.T, own]), np.vstack([nothing.T, shapes.T, own])]
        )


def _step(omega: float, damping: float, step: float) -> FloatArray:
    """Return displacement and velocity of a mode a step on, of both, old and new force, (2, 4)."""
    a = np.zeros((4, 4))
    a[0, 1], a[1, 0], a[1, 1] = 1.0, -(omega**2), -damping
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

    Raises
    ------
    DivergedError
        If a force is too steep for the steps.
    """
    n, r, n_samples = moved.shape
    which = np.array([int(one.force.of_velocity) for one in found])
    reading = np.stack([stepper.reading[kind][:, i] for i, kind in enumerate(which)], axis=1)
    at_once = (stepper.push @ reading).T  # what a force does within its own step, (r, r)
    given = np.where(which[:, None], velocity, moved).transpose(2, 0, 1).copy()
    out = np.empty((n_samples, n, r))
    state = np.zeros((n, len(stepper.turn)))
    force = np.zeros((n, r))
    with np.errstate(over="ignore", invalid="ignore"):
        for t in range(n_samples):
            state = state @ stepper.turn
            force = _balanced(found, given[t] + state @ reading, at_once, force)
            state += force @ stepper.push
            out[t] = force
    if not np.isfinite(out).all():
        raise DivergedError(
            "a nonlinear force is too steep to be stepped through time at this level",
            field="excitation.level",
            allowed="a lower level, or the expected route",
        )
    return np.asarray(-out.transpose(1, 2, 0))


def _balanced(
    found: Sequence[Linearised], free: FloatArray, own: FloatArray, guess: FloatArray
) -> FloatArray:
    """Return the forces on the structure (n, r) that agree with their motion: F = -g(free + own F)."""
    force = guess
    if len(found) == 1:
        one, soft = found[0], float(own[0, 0])
        for _ in range(NEWTON):
            x = free + soft * force
            force = force - (force + one.residual(x)) / (1 + soft * one.residual_slope(x))
        return force
    for _ in range(NEWTON):
        x = free + force @ own.T
        left = force + np.stack([one.residual(x[:, i]) for i, one in enumerate(found)], axis=1)
        slope = np.stack([one.residual_slope(x[:, i]) for i, one in enumerate(found)], axis=1)
        matrix = np.eye(len(found)) + slope[:, :, None] * own
        force = force - np.linalg.solve(matrix, left[:, :, None])[:, :, 0]
    return force
