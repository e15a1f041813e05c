"""Refinement of the low modes of a dense eigensolution by inverse iteration."""

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve, eigh

from modallab.core.arrays import FloatArray
from modallab.fe.settings import EIGENSOLUTION


def refined_modes(
    mass: FloatArray, stiffness: FloatArray, squares: FloatArray, shapes: FloatArray, n_rigid: int
) -> tuple[FloatArray, FloatArray]:
    """Return all eigenvalues (n,) and mass-normalised shapes (n, n), the low ones refined.

    The error of a dense solution is rounding of the highest eigenvalue: for a low mode 1e-16 times the ratio
    of the two, over the distance to the next mode, so that close modes are mixed. One step of subspace
    iteration with Rayleigh-Ritz projection reduces it to rounding of the lowest elastic eigenvalue:
    Parlett, The Symmetric Eigenvalue Problem (1980), 14.3.
    """
    if n_rigid == len(squares):
        return squares, shapes
    stop = int(np.searchsorted(squares, EIGENSOLUTION.refined_eigenvalue_range * squares[n_rigid]))
    bodies, low, high = np.split(shapes, [n_rigid, stop], axis=1)
    shift = float(squares[n_rigid])
    try:
        factor = cho_factor(stiffness + shift * mass)
    except LinAlgError:  # a mechanism: its eigenvalue is zero but for rounding
        return squares, shapes
    iterated = cho_solve(factor, mass @ low)
    iterated -= bodies @ (bodies.T @ (mass @ iterated))
    size = np.sqrt((iterated * (mass @ iterated)).sum(axis=0))
    iterated, low = iterated / size, low / size
    mass_times_shapes = mass @ iterated
    gram, inverse = iterated.T @ mass_times_shapes, mass_times_shapes.T @ low
    values, rotation = eigh((inverse + inverse.T) / 2, (gram + gram.T) / 2)
    rotated = iterated @ rotation
    low = rotated * np.where((rotated * (mass @ low)).sum(axis=0) < 0, -1.0, 1.0)  # keep the signs
    high = high - low @ (low.T @ (mass @ high))
    values = np.concatenate([squares[:n_rigid], values - shift, squares[stop:]])
    return values, np.hstack([bodies, low, high])
