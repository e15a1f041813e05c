"""Shapes on one scale out of modal constants."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray


def scaled_shapes(
    constant: ComplexArray, error: FloatArray, drive: int | None, sense: int, shared: float = 0.0
) -> tuple[ComplexArray, FloatArray]:
    """Return shapes and standard errors of their size, (n_modes, n_frf).

    Mass-normalised, `phi_j = A_1j/sqrt(A_11)`, the root with its real part positive; the error of the drive
    point's constant reaches every component. A drive point that stands still gives no scale: zeros.
    Without a drive point: the largest component turned to 1.

    Parameters
    ----------
    constant, error
        (n_modes, n_frf) 1/kg, of receptance, and the standard error of either part.
    drive
        Which of the FRFs is that of the drive point, None if none is.
    sense
        -1 where force and accelerometer at the drive point are of opposite sense, else 1.
    shared
        Correlation of the relative errors of any two constants, 0 to 1: what is wrong with all by one part
        is wrong with shapes by half of it.
    """
    if drive is None:
        return _unscaled(constant, error)
    return _mass_normalised(constant, error, drive, sense, shared)


def _mass_normalised(
    constant: ComplexArray, error: FloatArray, at: int, sense: int, shared: float
) -> tuple[ComplexArray, FloatArray]:
    own = sense * constant[:, at, None]
    moves = own != 0
    root = np.sqrt(np.where(moves, own, 1.0))
    shape = np.where(moves, constant / root, 0.0)
    own_error = error[:, at, None]
    response = error / np.abs(root)
    scale = np.abs(shape) * own_error / (2 * np.abs(root) ** 2)
    errors = np.sqrt(response**2 + scale**2 - 2 * shared * response * scale)
    errors[:, at] = (own_error / (2 * np.abs(root)))[:, 0]
    return shape, np.where(moves, errors, 0.0)


def _unscaled(constant: ComplexArray, error: FloatArray) -> tuple[ComplexArray, FloatArray]:
    rows = np.arange(len(constant))
    largest = constant[rows, np.abs(constant).argmax(axis=1)][:, None]
    moves = largest != 0
    safe = np.where(moves, largest, 1.0)
    return np.where(moves, constant / safe, 0.0), np.where(moves, error / np.abs(safe), 0.0)
