"""Receptance of a system with its attachments: by modes and the Woodbury identity, or directly."""

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.fe.modes import ModalResponse
from modallab.fe.system import SMALL, DynamicSystem


def attached(
    response: ModalResponse, system: DynamicSystem, left: FloatArray, right: FloatArray
) -> ComplexArray:
    """Return the receptance of a system with its attachments, from modes of its matrices alone.

    alpha - alpha B (I + Z B^T alpha B)^-1 Z B^T alpha: exact, and regular where an attachment has
    no stiffness (Woodbury identity).

    Parameters
    ----------
    response
        `system.base_modes(...).at(omega)`.
    left, right
        (n, n_out) and (n, n_in) motions asked for, unit vectors for single DoFs.

    Returns
    -------
    (n_freq, n_out, n_in), m/N.
    """
    if not system.attachments:
        return response.receptance(left, right)
    columns = system.stacked
    n_out, n_in = left.shape[1], right.shape[1]
    all_alpha = response.receptance(np.hstack([left, columns]), np.hstack([right, columns]))
    alpha, to_b = all_alpha[:, :n_out, :n_in], all_alpha[:, :n_out, n_in:]
    from_b, within = all_alpha[:, n_out:, :n_in], all_alpha[:, n_out:, n_in:]
    z = system.attached_stiffness(response.omega)
    inner = z @ within
    inner[:, np.arange(z.shape[1]), np.arange(z.shape[1])] += 1.0
    return np.asarray(alpha - to_b @ np.linalg.solve(inner, z @ from_b))


def receptance(system: DynamicSystem, freq: FloatArray, left: FloatArray, right: FloatArray) -> ComplexArray:
    """Return the receptance (n_freq, n_out, n_in), m/N, at `freq` (n_freq,) Hz, by modal sum."""
    omega = 2 * np.pi * np.asarray(freq, float)
    response = system.base_modes(float(np.max(freq))).at(omega)
    return attached(response, system, left, right)


def direct_receptance(
    system: DynamicSystem, freq: FloatArray, left: FloatArray, right: FloatArray
) -> ComplexArray:
    """Return the receptance (n_freq, n_out, n_in), m/N, by solving at every line: slow and exact.

    The reference that the modal sum is held against, and the way for damping that no modes decouple.
    """
    full = system.folded()
    omega = 2 * np.pi * np.asarray(freq, float)

    def dynamic_stiffness(w: float) -> csc_array:
        z = full.stiffness - w**2 * full.mass + 0j
        if full.damping is not None:
            z = z + 1j * full.damping
        if full.viscous is not None:
            z = z + 1j * w * full.viscous
        return csc_array(z)

    if len(system.dofs) < SMALL:
        stack = np.array([dynamic_stiffness(w).toarray() for w in omega])
        return np.asarray(left.T @ np.linalg.solve(stack, right.astype(complex)))
    return np.array([left.T @ splu(dynamic_stiffness(w)).solve(right.astype(complex)) for w in omega])
