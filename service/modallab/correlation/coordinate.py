"""Coordinate criteria: agreement of paired modes at each degree of freedom."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray


def comac(first: ComplexArray, second: ComplexArray) -> FloatArray:
    """Return the coordinate modal assurance criterion of every DoF, (n_dof,), 0 to 1.

    `(sum |phi_x phi_a|)^2 / (sum |phi_x|^2 sum |phi_a|^2)` over paired modes, each shape first brought to
    size 1, so that no scale of a mode matters. It does not see signs. A DoF that moves in neither set
    agrees: 1.

    Parameters
    ----------
    first, second
        (n_dof, n_pairs), column beside column.

    References
    ----------
    Lieven, N. A. J. and Ewins, D. J. (1988), Proc. 6th International Modal Analysis Conference, 690-695.
    """
    first_sizes, second_sizes = _sizes(first), _sizes(second)
    sizes = (first_sizes**2).sum(axis=1) * (second_sizes**2).sum(axis=1)
    still = ((first_sizes**2).sum(axis=1) == 0) & ((second_sizes**2).sum(axis=1) == 0)
    product = (first_sizes * second_sizes).sum(axis=1) ** 2
    values = np.divide(product, sizes, out=still.astype(float), where=sizes > 0)
    return np.asarray(np.minimum(values, 1.0))


def ecomac(first: ComplexArray, second: ComplexArray) -> FloatArray:
    """Return the enhanced coordinate criterion of every DoF, (n_dof,): 0 agrees, 1 is opposite throughout.

    `sum |phi_x - phi_a| / (2 n_pairs)` over paired modes, each shape brought to a largest entry of 1 and the
    first to its partner's phase. Unlike CoMAC it shows a reversed sign. Errors are weighted by the motion of
    the DoF, so that noise near nodes has little influence; a wrong gain at the largest entry of a shape is
    visible at the other DoFs, too.

    Parameters
    ----------
    first, second
        (n_dof, n_pairs), column beside column.

    References
    ----------
    Hunt, D. L. (1992), Proc. 10th International Modal Analysis Conference, 66-71.
    """
    if not first.shape[1]:
        return np.zeros(len(first))
    product = (first.conj() * second).sum(axis=0)
    phase = np.where(product == 0, 1.0, product / np.where(product == 0, 1.0, np.abs(product)))
    return np.asarray(np.abs(_unit(first) * phase - _unit(second)).sum(axis=1) / (2 * first.shape[1]))


def _sizes(shapes: ComplexArray) -> FloatArray:
    """Return the magnitudes of shapes of length 1."""
    length = np.linalg.norm(shapes, axis=0)
    return np.asarray(np.abs(shapes) / np.where(length > 0, length, 1.0))


def _unit(shapes: ComplexArray) -> ComplexArray:
    largest = np.abs(shapes).max(axis=0, initial=0.0)
    return shapes / np.where(largest > 0, largest, 1.0)
