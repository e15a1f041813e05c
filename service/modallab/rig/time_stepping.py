"""Time integration of nonlinear forces by modal superposition."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import DivergedError
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.fe.system import DynamicSystem
from modallab.rig.force_equilibrium import ForceEquilibrium
from modallab.rig.local_force import LinearisedForce
from modallab.rig.nonlinear_settings import TIME_STEPPING


@dataclass(frozen=True, eq=False)
class ModalFeedback:
    """Real modes of a structure with passive sources, at its nonlinear forces.

    Structural damping counts as viscous damping of the same width, which is exact at resonance: the
    force that is fed back here is the residual of the equivalent linearisation, small against the force.
    """

    shapes: FloatArray  # (r, m) of the motions, 1/sqrt(kg)
    omega: FloatArray  # (m,) rad/s
    damping: FloatArray  # (m,) 1/s, twice the rate of decay

    @classmethod
    def of(cls, system: DynamicSystem, dofs: tuple[Dof, ...]) -> "ModalFeedback":
        """Return the modal model of a system at some DoFs."""
        basis = system.modes()
        columns = system.selection(dofs)
        shapes = columns.T @ basis.shapes[: len(columns)].real
        omega = 2 * np.pi * basis.frequencies
        damping = 2 * basis.decay_rates(TIME_STEPPING.rigid_body_rate)
        participates = np.abs(shapes).max(axis=0) > COMPARISON_ROUNDING * np.abs(shapes).max()
        return cls(shapes[:, participates], omega[participates], damping[participates])


def check_bounded(feedback: ModalFeedback, linearised: Sequence[LinearisedForce]) -> None:
    """Raise if the integration of large motions is unstable.

    The straight line of a damper is in the feedback mode by mode, without what it couples. A force that
    falls behind its line at loud motions takes the line off again, couplings and all: if it is strong
    that feeds motions which several modes share.

    Raises
    ------
    DivergedError
        If a motion `TIME_STEPPING.loud_ratio` times the usual one grows.
    """
    loud_coefficients = [
        float(
            linearised_force.force.equivalent_coefficients(
                np.array(TIME_STEPPING.loud_ratio * linearised_force.rms)
            )[0]
        )
        if linearised_force.rms > 0
        else 0.0
        for linearised_force in linearised
    ]
    coefficient_drop = np.minimum(
        np.array(loud_coefficients) - [linearised_force.slope for linearised_force in linearised], 0.0
    )
    if not coefficient_drop.any():
        return
    of_velocity = np.array([linearised_force.force.of_velocity for linearised_force in linearised])
    shapes, omega = feedback.shapes, feedback.omega
    modal_matrices = [
        (shapes.T * np.where(kind, coefficient_drop, 0.0)) @ shapes for kind in (~of_velocity, of_velocity)
    ]
    stiffness, damping = np.diag(omega**2) + modal_matrices[0], np.diag(feedback.damping) + modal_matrices[1]
    state = np.block([[np.zeros_like(stiffness), np.eye(len(omega))], [-stiffness, -damping]])
    if np.linalg.eigvals(state).real.max() > TIME_STEPPING.growth_tolerance * omega.max():
        strongest = linearised[int(coefficient_drop.argmin())].force.dof
        raise DivergedError(
            f"the nonlinear force at {strongest} holds too hard to be stepped through time at this level",
            field="excitation.level",
            allowed="a higher level, or the expected route",
        )


class Stepper:
    """Exact integrator of modes under piecewise linear forces, for several structures in parallel.

    Exact for such forces. Modes are turned once a block; within it the motion at a force is what the modes
    would do alone, and a convolution of the forces with the structure's answer. The force that a step
    ends with is left out of the modes until the next one, (n_run, n, 2 m) displacements and velocities.
    """

    def __init__(
        self,
        feedbacks: Sequence[ModalFeedback],
        of_velocity: Sequence[bool],
        step: float,
        block: int = TIME_STEPPING.block_steps,
    ) -> None:
        most = max(feedback.shapes.shape[1] for feedback in feedbacks)
        parts = [_block_matrices(_padded(feedback, most), of_velocity, step, block) for feedback in feedbacks]
        # (n_run, 2, 2, m) over a block; (n_run, 2 m, block r) from modes to motions at its steps;
        # (n_run, block r, 2 m) from forces to modes at its end; (block, n_run, r, r) from a force to motions.
        self.propagator, self.readout, self.input_matrix, self.impulse_response = (
            np.array([matrices[i] for matrices in parts]) for i in range(4)
        )
        self.impulse_response = np.ascontiguousarray(self.impulse_response.swapaxes(0, 1))
        self.block = block

    def free_motion(self, state: FloatArray) -> FloatArray:
        """Return the motions (block, n_run, n, r) over a block without forces in it."""
        n_run, n, _ = state.shape
        return np.moveaxis((state @ self.readout).reshape(n_run, n, self.block, -1), 2, 0)

    def advance(self, state: FloatArray, forces: FloatArray) -> FloatArray:
        """Return the modal state after a block with forces (block, n_run, n, r)."""
        n_run, n, n_states = state.shape
        q, v = state[..., : n_states // 2], state[..., n_states // 2 :]
        block_forces = np.moveaxis(forces, 0, 2).reshape(n_run, n, -1)
        out = block_forces @ self.input_matrix
        for state_part, part in enumerate((out[..., : n_states // 2], out[..., n_states // 2 :])):
            part += self.propagator[:, state_part, 0, None] * q
            part += self.propagator[:, state_part, 1, None] * v
        return np.asarray(out)


def _padded(feedback: ModalFeedback, n_modes: int) -> ModalFeedback:
    """Return the modal model padded to `n_modes` with modes of zero shape."""
    missing = n_modes - feedback.shapes.shape[1]
    shapes, omega, damping = (np.pad(a, (*[(0, 0)] * (a.ndim - 1), (0, missing))) for a in _parts(feedback))
    return ModalFeedback(shapes, omega, damping)


def _parts(feedback: ModalFeedback) -> tuple[FloatArray, FloatArray, FloatArray]:
    return feedback.shapes, feedback.omega, feedback.damping


def _block_matrices(
    feedback: ModalFeedback, of_velocity: Sequence[bool], step: float, block: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the four matrices of a `Stepper` for one structure, over one block of steps."""
    r, m = feedback.shapes.shape
    exact = np.array([_step(w, c, step) for w, c in zip(feedback.omega, feedback.damping, strict=True)])
    a, b_old, b_new = exact[:, :, :2], exact[:, :, 2], exact[:, :, 3]  # (m, 2, 2), (m, 2), (m, 2)
    c = np.einsum("mij,mj->mi", a, b_new) + b_old
    derivative = np.array([int(velocity) for velocity in of_velocity])
    reading = np.zeros((2, m, r))
    reading[derivative, :, np.arange(r)] = feedback.shapes
    powers = [np.broadcast_to(np.eye(2), a.shape)]
    for _ in range(block):
        powers.append(a @ powers[-1])
    propagators = np.array(powers)  # (block + 1, m, 2, 2)
    readout = np.einsum("bmij,imr->jmbr", propagators[:-1], reading).reshape(2 * m, -1)
    impulse_state = np.einsum("bmij,mj->bim", propagators[:-1], c)
    input_matrix = np.einsum("bim,rm->brim", impulse_state[::-1], feedback.shapes).reshape(-1, 2 * m)
    later_response = np.einsum("bim,imr,sm->brs", impulse_state[:-1], reading, feedback.shapes)
    immediate_response = np.einsum("mi,imr,sm->rs", b_new, reading, feedback.shapes)
    return (
        propagators[-1].transpose(1, 2, 0),
        readout,
        input_matrix,
        np.concatenate([immediate_response[None], later_response]),
    )


def _step(omega: float, damping: float, step: float) -> FloatArray:
    """Return the step matrix (2, 4): displacement and velocity from the old state, old and new force."""
    a = np.zeros((4, 4))
    a[0, 1], a[1, 0], a[1, 1] = 1.0, -(omega**2), -damping
    a[1, 2], a[2, 3] = 1.0, 1.0 / step  # force u, rising at (new - old)/step
    transition = expm(a * step)[:2]
    return np.column_stack([transition[:, :2], transition[:, 2] - transition[:, 3], transition[:, 3]])


def residual_forces(
    linearised: Sequence[Sequence[LinearisedForce]],
    linear_motion: Callable[[int, int], FloatArray],
    n_samples: int,
    stepper: Stepper,
) -> FloatArray:
    """Return the residual of every local force over time, (n_samples, n_run, n, r) N.

    The motion is what the sources alone cause in the linearised structure plus what the residuals
    themselves cause, from rest; the forces at the ends of the steps are found by Newton's method.

    Parameters
    ----------
    linearised
        By run, of the same laws.
    linear_motion
        From the first and the last sample, (n, n_run, n_records, r) m or m/s, whichever each force takes,
        at the local forces of the linearised structures: of records that are stepped side by side.

    Raises
    ------
    DivergedError
        If a force is too steep for the steps.
    """
    equilibrium, block = ForceEquilibrium(linearised, stepper.impulse_response), stepper.block
    first = linear_motion(0, 1)[0]
    out = np.empty((n_samples, *first.shape))
    force = np.zeros_like(first)
    state = np.zeros((*first.shape[:2], stepper.readout.shape[1]))
    with np.errstate(over="ignore", invalid="ignore"):
        for start in range(0, n_samples, block):
            end = min(start + block, n_samples)
            free_motion = stepper.free_motion(state)[: end - start] + linear_motion(start, end)
            forces = equilibrium.forces(free_motion, force)
            out[start:end], force = forces, forces[-1]
            if end - start == block:
                state = stepper.advance(state, forces)
    if not np.isfinite(out).all():
        raise DivergedError(
            "a nonlinear force is too steep to be stepped through time at this level",
            field="excitation.level",
            allowed="a lower level, or the expected route",
        )
    return np.negative(out, out=out)
