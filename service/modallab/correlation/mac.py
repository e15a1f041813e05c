"""Modal assurance criterion (MAC) and pairing of modes."""

import numpy as np
import scipy

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.correlation.settings import PAIRING


def mac(first: ComplexArray | FloatArray, second: ComplexArray | FloatArray) -> FloatArray:
    """Return the modal assurance criterion of every pair of shapes, (n_first, n_second), 0 to 1.

    `|phi_x^H phi_a|^2 / (phi_x^H phi_x phi_a^H phi_a)` [3.19], with the conjugate transpose, so that a
    complex scale of either shape drops out. A shape of zeros has MAC 0.

    Parameters
    ----------
    first, second
        (n_dof, n_first) and (n_dof, n_second), any unit.

    References
    ----------
    Allemang, R. J. and Brown, D. L. (1982), Proc. 1st International Modal Analysis Conference, 110-116.
    """
    sizes = np.outer((np.abs(first) ** 2).sum(axis=0), (np.abs(second) ** 2).sum(axis=0))
    product = np.abs(first.conj().T @ second) ** 2
    values = np.divide(product, sizes, out=np.zeros(sizes.shape), where=sizes > 0)
    return np.asarray(np.minimum(values, 1.0))


def pair_modes(values: FloatArray, floor: float = PAIRING.min_mac) -> tuple[tuple[int, int], ...]:
    """Return pairs (row, column) of a MAC matrix, each used once, in rising row.

    The assignment whose MAC values add up to most: where two rows want the same column, the pair of
    pairs decides and not the order of the rows. Pairs below `floor` are left out.
    """
    rows, columns = scipy.optimize.linear_sum_assignment(
        np.where(values >= floor, values, 0.0), maximize=True
    )
    return tuple(
        (int(r), int(c))
        for r, c in zip(rows, columns, strict=True)
        if values[r, c] >= max(floor, PRODUCT_ROUNDING)
    )


def pole_weighted_mac(
    first: ComplexArray | FloatArray,
    second: ComplexArray | FloatArray,
    first_eigenvalues: ComplexArray,
    second_eigenvalues: ComplexArray,
    order: int = PAIRING.pole_order,
) -> FloatArray:
    """Return the pole-weighted MAC of every pair of modes, (n_first, n_second), 0 to 1.

    The MAC of the long vectors [phi; z phi; ...; z^order phi]. It is high for modes whose shapes and poles
    are both similar; modes whose shapes are similar at too few DoFs are distinguished by frequency. z = exp(s
    dt) with the upper pole s of each mode, and dt such that the highest of all turns by half a circle.

    Parameters
    ----------
    first, second
        (n_dof, n_first) and (n_dof, n_second), any unit.
    first_eigenvalues, second_eigenvalues
        (n_first,) and (n_second,) omega_r^2 (1 + i eta_r), rad^2/s^2.
    order
        The higher the order, the closer the poles that are distinguished; 0 is the plain MAC.

    References
    ----------
    Phillips, A. W. and Allemang, R. J. (2005), Proc. 23rd International Modal Analysis Conference; in z, of
    order 5 to 10: Phillips, A. W., Allemang, R. J. and Brown, D. L. (2011), Proc. 29th, 363-384.
    """
    poles = [1j * np.sqrt(np.asarray(values, complex)) for values in (first_eigenvalues, second_eigenvalues)]
    highest = max((float(np.abs(p).max(initial=0.0)) for p in poles), default=0.0)
    step = np.pi / highest if highest > 0 else 0.0
    powers = np.arange(order + 1)[:, None]
    weights = [np.exp(powers * p * step) for p in poles]
    # The long vector is a Kronecker product, and so is every product of two: the MACs multiply.
    return mac(first, second) * mac(*weights)
