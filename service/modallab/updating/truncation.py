"""Modal truncation: contribution of modes above a basis to derivatives of shapes at the sensors."""

from collections.abc import Iterator
from enum import StrEnum

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.core.numerics import SUM_ROUNDING
from modallab.fe.modes import ModalBasis


class HigherModes(StrEnum):
    """Treatment of modes above a truncated basis."""

    OMITTED = "omitted"  # truncated sum
    STATIC = "static"  # static residual: one solve for each sensor
    EXACT = "exact"  # Chebyshev series of solves, of undamped modes; faster the farther the higher modes are


def higher_modes_at(
    basis: ModalBasis, modes: IntArray, sensors: FloatArray, higher_modes: HigherModes
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield columns X (n, n_dof) and factors c (n_modes,) of the response of higher modes: sum of c_r X^T f.

    For mode r and a load f that response is s^T sum phi phi^T f / (lambda - lambda_r) over the higher modes.
    With sigma the shift of the factorised K + sigma M, t = 1 / (lambda + sigma) lies between 0 and
    1 / (highest + sigma), and 1 / (lambda - lambda_r) = t / (1 - (lambda_r + sigma) t), a series in Chebyshev
    polynomials of t whose coefficients fall geometrically; its columns are the same for all modes and
    coefficients.

    Raises
    ------
    InvalidInputError
        If the series is asked for a basis of damped modes.
    """
    remainder = basis.remainder
    if remainder is None or higher_modes is HigherModes.OMITTED:
        return
    columns = remainder.static(sensors)
    if higher_modes is HigherModes.STATIC:
        yield columns, np.ones(len(modes))
        return
    if basis.eigenvalues.imag.any():
        raise InvalidInputError(
            "modes above a basis of damped modes count statically",
            field="higher_modes",
            value=higher_modes.value,
            allowed=[HigherModes.OMITTED, HigherModes.STATIC],
        )
    eigenvalue_ratio = _eigenvalue_ratio(basis, modes)
    centre = 2 / eigenvalue_ratio - 1
    width = np.sqrt(centre**2 - 1)
    decay, factor = centre - width, 2 / (eigenvalue_ratio * width)
    yield columns, factor
    previous, scale = columns, _highest_eigenvalue(basis) + remainder.shift
    columns = 2 * scale * remainder.static(remainder.mass @ columns) - columns
    terms = int(np.ceil(np.log(SUM_ROUNDING) / np.log(decay.max())))
    for _ in range(terms):
        factor = factor * decay
        yield columns, 2 * factor
        following = 4 * scale * remainder.static(remainder.mass @ columns) - 2 * columns - previous
        previous, columns = columns, following


def truncation_bound(basis: ModalBasis, modes: IntArray, higher_modes: HigherModes) -> FloatArray:
    """Return a bound of the error of derivatives, over the static contribution of higher modes (n_modes,).

    For higher modes, 1 / (lambda - lambda_r) is no more than 1 / (1 - rho_r) of 1 / (lambda + sigma), with
    rho_r = (lambda_r + sigma) / (highest + sigma).
    """
    if basis.remainder is None or higher_modes is HigherModes.EXACT:
        is_complete = basis.remainder is not None or np.isinf(basis.frequency_max)
        return np.full(len(modes), 0.0 if is_complete else np.inf)
    eigenvalue_ratio = _eigenvalue_ratio(basis, modes)
    return np.asarray(
        (eigenvalue_ratio if higher_modes is HigherModes.STATIC else 1.0) / (1 - eigenvalue_ratio)
    )


def _eigenvalue_ratio(basis: ModalBasis, modes: IntArray) -> FloatArray:
    """Return (lambda_r + sigma) / (highest + sigma), below 1, (n_modes,)."""
    assert basis.remainder is not None
    shift = basis.remainder.shift
    return np.asarray((basis.eigenvalues.real[modes] + shift) / (_highest_eigenvalue(basis) + shift))


def _highest_eigenvalue(basis: ModalBasis) -> float:
    return float((2 * np.pi * basis.frequency_max) ** 2)
