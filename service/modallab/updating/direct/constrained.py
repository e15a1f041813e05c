"""Steps common to methods with measured modes as a constraint."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import UnderdeterminedError
from modallab.updating.direct.settings import DIRECT_UPDATING


def modal_mass(shapes: FloatArray, mass: FloatArray) -> FloatArray:
    """Return the modal mass matrix Phi^T M Phi, (m, m).

    Parameters
    ----------
    shapes
        (n, m) 1/sqrt(kg).
    mass
        (n, n) kg.

    Raises
    ------
    UnderdeterminedError
        If the shapes are linearly dependent in this mass.
    """
    product = shapes.T @ mass @ shapes
    product = (product + product.T) / 2
    values = np.linalg.eigvalsh(product)
    if not values[0] * DIRECT_UPDATING.max_condition > values[-1]:
        raise UnderdeterminedError(
            f"the {len(values)} measured shapes are not independent of one another",
            field="modes",
            value=len(values),
            allowed="modes that measured degrees of freedom tell apart",
        )
    return np.asarray(product)


def mass_orthonormal(shapes: FloatArray, mass: FloatArray) -> FloatArray:
    """Return the nearest mass-orthonormal shapes: Phi (Phi^T M Phi)^(-1/2).

    Parameters
    ----------
    shapes
        (n, m) 1/sqrt(kg).
    mass
        (n, n) kg.

    Raises
    ------
    UnderdeterminedError
        If the shapes are linearly dependent in this mass.

    References
    ----------
    Targoff, W. P. (1976), AIAA Journal 14(2), 164; Baruch, M. and Bar Itzhack, I. Y. (1978), AIAA Journal
    16(4), 346-351.
    """
    values, eigenvectors = np.linalg.eigh(modal_mass(shapes, mass))
    return np.asarray(shapes @ (eigenvectors / np.sqrt(values)) @ eigenvectors.T)


def constrained_stiffness(
    stiffness: FloatArray, mass: FloatArray, shapes: FloatArray, squares: FloatArray
) -> FloatArray:
    """Return the nearest stiffness matrix with the given modes, (n, n), N/m [2.7].

    K + D + D^T with D = 1/2 M Phi (Phi^T K Phi + Lambda) Phi^T M - K Phi Phi^T M, nearest in the norm of
    M^(-1/2) dK M^(-1/2).

    Parameters
    ----------
    stiffness, mass
        (n, n) N/m and kg.
    shapes
        (n, m) orthonormal in `mass`.
    squares
        (m,) rad^2/s^2.
    """
    inertia_shapes = mass @ shapes
    elastic_forces = stiffness @ shapes
    modal_stiffness = shapes.T @ elastic_forces + np.diag(squares)
    half = 0.5 * inertia_shapes @ modal_stiffness @ inertia_shapes.T - elastic_forces @ inertia_shapes.T
    return np.asarray(stiffness + half + half.T)
