"""Receptance of a system with its attachments: by modes and the Woodbury identity, or directly."""

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.fe.modes import ModalResponse
from modallab.fe.settings import EIGENSOLUTION
from modallab.fe.small_systems import product, solve_small
from modallab.fe.system import DynamicSystem


def attached(
    response: ModalResponse, system: DynamicSystem, outputs: FloatArray, inputs: FloatArray
) -> ComplexArray:
    """Return the receptance of a system with its attachments, from modes of its matrices alone.

    alpha - alpha B (I + Z B^T alpha B)^-1 Z B^T alpha: exact, and regular where an attachment has
    no stiffness (Woodbury identity).

    Parameters
    ----------
    response
        `system.base_modes(...).at(omega)`.
    outputs, inputs
        (n, n_out) and (n, n_in) motions, unit vectors for single DoFs.

    Returns
    -------
    (n_freq, n_out, n_in), m/N.
    """
    if not system.attachments:
        return response.receptance(outputs, inputs)
    columns = system.stacked_columns
    alpha = response.receptance(np.hstack([outputs, columns]), np.hstack([inputs, columns]))
    return with_attached_stiffness(alpha, system.attached_stiffness(response.omega))


def with_attached_stiffness(alpha: ComplexArray, z: ComplexArray) -> ComplexArray:
    """Return the receptance with z (..., r, r) attached to the last r rows and columns of alpha."""
    r = z.shape[-1]
    if r == 0:  # attachments without effect have no columns
        return alpha
    to_b, from_b, within = alpha[..., :-r, -r:], alpha[..., -r:, :-r], alpha[..., -r:, -r:]
    if r == 1:  # one division instead of a solver call for every line
        return np.asarray(alpha[..., :-1, :-1] - to_b * (z / (1 + z * within)) * from_b)
    inner = product(z, within)
    inner[..., np.arange(r), np.arange(r)] += 1.0
    return np.asarray(alpha[..., :-r, :-r] - product(to_b, solve_small(inner, product(z, from_b))))


def receptance(
    system: DynamicSystem, freq: FloatArray, outputs: FloatArray, inputs: FloatArray
) -> ComplexArray:
    """Return the receptance (n_freq, n_out, n_in), m/N, at `freq` (n_freq,) Hz, by modal sum."""
    omega = 2 * np.pi * np.asarray(freq, float)
    response = system.base_modes(float(np.max(freq))).at(omega)
    return attached(response, system, outputs, inputs)


def direct_receptance(
    system: DynamicSystem, freq: FloatArray, outputs: FloatArray, inputs: FloatArray
) -> ComplexArray:
    """Return the receptance (n_freq, n_out, n_in), m/N, by a linear solution at every line.

    Slow; the reference for the modal sum.
    """
    folded = system.folded()
    omega = 2 * np.pi * np.asarray(freq, float)

    def dynamic_stiffness(w: float) -> csc_array:
        z = folded.stiffness - w**2 * folded.mass + 0j
        if folded.damping is not None:
            z = z + 1j * folded.damping
        if folded.viscous is not None:
            z = z + 1j * w * folded.viscous
        return csc_array(z)

    if len(system.dofs) < EIGENSOLUTION.dense_dofs:
        stack = np.array([dynamic_stiffness(w).toarray() for w in omega])
        return np.asarray(outputs.T @ np.linalg.solve(stack, inputs.astype(complex)))
    return np.array([outputs.T @ splu(dynamic_stiffness(w)).solve(inputs.astype(complex)) for w in omega])
