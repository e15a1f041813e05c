"""Low modes of a dense solution, made as exact as their matrices."""

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve, eigh

from modallab.core.arrays import FloatArray
from modallab.fe.settings import EIGENSOLUTION


def refined_modes(
    mass: FloatArray, stiffness: FloatArray, squares: FloatArray, shapes: FloatArray, n_rigid: int
) -> tuple[FloatArray, FloatArray]:
    """Return all eigenvalues (n,) and mass-normalised shapes (n, n), the low ones solved for once more.

    A dense solution is off by rounding of the highest eigenvalue: in a low mode by 1e-16 times their ratio,
    over the distance to the next, which mixes close modes. A step of inverse iteration of all of them
    together leaves rounding of the lowest one: Parlett, The Symmetric Eigenvalue Problem (1980), 14.3.
    """
    if n_rigid == len(squares):
        return squares, shapes
    stop = int(np.searchsorted(squares, EIGENSOLUTION.refined_eigenvalue_range * squares[n_rigid]))
    bodies, low, high = np.split(shapes, [n_rigid, stop], axis=1)
    shift = float(squares[n_rigid])
    try:
        factor = cho_factor(stiffness + shift * mass)
    except LinAlgError:  # a mechanism, whose eigenvalue is rounding itself
        return squares, shapes
    iterated = cho_solve(factor, mass @ low)
    iterated -= bodies @ (bodies.T @ (mass @ iterated))
    size = np.sqrt((iterated * (mass @ iterated)).sum(axis=0))
    iterated, low = iterated / size, low / size
    mass_times_shapes = mass @ iterated
    gram, inverse = iterated.T @ mass_times_shapes, mass_times_shapes.T @ low
    values, rotation = eigh((inverse + inverse.T) / 2, (gram + gram.T) / 2)
    rotated = iterated @ rotation
    low = rotated * np.where((rotated * (mass @ low)).sum(axis=0) < 0, -1.0, 1.0)  # each in its old sense
    high = high - low @ (low.T @ (mass @ high))
    values = np.concatenate([squares[:n_rigid], values - shift, squares[stop:]])
    return values, np.hstack([bodies, low, high])
