"""What modes above a basis add to the derivatives of its shapes, found at the sensors."""

from collections.abc import Iterator
from enum import StrEnum

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.fe.modes import ModalBasis

ROUNDING = 1e-14  # of what modes above add, that an exact series leaves out


class HigherModes(StrEnum):
    """How modes above a basis count; of a basis that holds all there are none."""

    LEFT_OUT = "left_out"  # the sum ends with the basis
    STATIC = "static"  # as if they answered at once: one solve a sensor
    EXACT = "exact"  # by a series of solves that converges as fast as the modes above are far: undamped ones


def higher_modes_at(
    basis: ModalBasis, modes: IntArray, sensors: FloatArray, above: HigherModes
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield columns X (n, n_dof) and factors c (n_modes,): modes above answer a load f with sum of c_r X^T f.

    Of mode r that is s^T sum phi phi^T f / (lambda - lambda_r) over modes above. With sigma the shift of
    the factorised K + sigma M, t = 1 / (lambda + sigma) lies between 0 and 1 / (highest + sigma), and
    1 / (lambda - lambda_r) = t / (1 - (lambda_r + sigma) t), a series in Chebyshev polynomials of t whose
    coefficients fall geometrically; its columns are the same for all modes and coefficients.

    Raises
    ------
    InvalidInputError
        If the series is asked for a basis of damped modes, whose matrices are others.
    """
    remainder = basis.remainder
    if remainder is None or above is HigherModes.LEFT_OUT:
        return
    columns = remainder.static(sensors)
    if above is HigherModes.STATIC:
        yield columns, np.ones(len(modes))
        return
    if basis.eigenvalues.imag.any():
        raise InvalidInputError(
            "modes above a basis of damped modes count statically",
            field="above",
            value=above.value,
            allowed=f"{HigherModes.LEFT_OUT}, {HigherModes.STATIC}",
        )
    near = _nearness(basis, modes)
    centre = 2 / near - 1
    width = np.sqrt(centre**2 - 1)
    ratio, factor = centre - width, 2 / (near * width)
    yield columns, factor
    before, scale = columns, _highest(basis) + remainder.shift
    columns = 2 * scale * remainder.static(remainder.mass @ columns) - columns
    terms = int(np.ceil(np.log(ROUNDING) / np.log(ratio.max())))
    for _ in range(terms):
        factor = factor * ratio
        yield columns, 2 * factor
        after = 4 * scale * remainder.static(remainder.mass @ columns) - 2 * columns - before
        before, columns = columns, after


def left_out(basis: ModalBasis, modes: IntArray, above: HigherModes) -> FloatArray:
    """Return the share of what modes above can add statically that derivatives may be off by, (n_modes,).

    Of modes above, 1 / (lambda - lambda_r) is no more than 1 / (1 - rho_r) of 1 / (lambda + sigma), with
    rho_r = (lambda_r + sigma) / (highest + sigma).
    """
    if basis.remainder is None or above is HigherModes.EXACT:
        whole = basis.remainder is not None or np.isinf(basis.frequency_max)
        return np.full(len(modes), 0.0 if whole else np.inf)
    near = _nearness(basis, modes)
    return np.asarray((near if above is HigherModes.STATIC else 1.0) / (1 - near))


def _nearness(basis: ModalBasis, modes: IntArray) -> FloatArray:
    """Return (lambda_r + sigma) / (highest + sigma), below 1, (n_modes,)."""
    assert basis.remainder is not None
    shift = basis.remainder.shift
    return np.asarray((basis.eigenvalues.real[modes] + shift) / (_highest(basis) + shift))


def _highest(basis: ModalBasis) -> float:
    return float((2 * np.pi * basis.frequency_max) ** 2)
