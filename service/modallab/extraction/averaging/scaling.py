"""Scaling of shapes from modal constants."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray


def scaled_shapes(
    constant: ComplexArray,
    error: FloatArray,
    drive: int | None,
    sense: int,
    noise_correlation: FloatArray | float = 0.0,
) -> tuple[ComplexArray, FloatArray]:
    """Return shapes and standard errors of their modulus, (n_modes, n_frf).

    Mass-normalised, `phi_j = A_1j/sqrt(A_11)`, the root with its real part positive; the error of the drive
    point's constant affects every component. A drive point at rest gives no scale: zeros. Without a drive
    point the largest component is scaled to 1.

    Parameters
    ----------
    constant, error
        (n_modes, n_frf) 1/kg, of receptance, and the standard error of real and imaginary part.
    drive
        Index of the drive-point FRF, None if there is none.
    sense
        -1 where force and accelerometer at the drive point have opposite directions, else 1.
    noise_correlation
        Correlation of the relative errors of any two constants, 0 to 1: a relative error common to all
        constants is half as large in the shapes.
    """
    if drive is None:
        return _unscaled(constant, error)
    return _mass_normalised(constant, error, drive, sense, noise_correlation)


def _mass_normalised(
    constant: ComplexArray,
    error: FloatArray,
    drive_row: int,
    sense: int,
    noise_correlation: FloatArray | float,
) -> tuple[ComplexArray, FloatArray]:
    drive_constant = sense * constant[:, drive_row, None]
    moves = drive_constant != 0
    root = np.sqrt(np.where(moves, drive_constant, 1.0))
    shape = np.where(moves, constant / root, 0.0)
    drive_error = error[:, drive_row, None]
    response = error / np.abs(root)
    scale = np.abs(shape) * drive_error / (2 * np.abs(root) ** 2)
    errors = np.sqrt(response**2 + scale**2 - 2 * noise_correlation * response * scale)
    errors[:, drive_row] = (drive_error / (2 * np.abs(root)))[:, 0]
    return shape, np.where(moves, errors, 0.0)


def _unscaled(constant: ComplexArray, error: FloatArray) -> tuple[ComplexArray, FloatArray]:
    rows = np.arange(len(constant))
    largest = constant[rows, np.abs(constant).argmax(axis=1)][:, None]
    moves = largest != 0
    safe = np.where(moves, largest, 1.0)
    return np.where(moves, constant / safe, 0.0), np.where(moves, error / np.abs(safe), 0.0)
