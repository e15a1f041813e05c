"""Weighted sums over the lines that a fit of all modes in all FRFs needs, and its linear unknowns."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.jointly.modal_basis import ModalBasis, Rows, all_columns, all_slopes

Number = TypeVar("Number", np.float64, np.complex128)

AT_ONCE = 2**22  # numbers in a block of products, 32 MB
# A range so wide, of so many lines, is disturbed by how modes beyond it differ from a constant, and can tell.
WIDE, MANY = 0.5, 64
BEYOND = (1.5,)  # with the constant, all that lies above to 3 %, but for the mode next to the range
TINY = 1e-300
RIDGE = 1e-13  # of columns of unit length: keeps what rounding alone parts from running away


@dataclass(frozen=True, eq=False)
class Scaled:
    """Lines on scales of order one: omega up to 1, the weighted rms of each FRF 1.

    Where FRFs of several references share their modes' shapes, they are one response with a row for each
    line and reference, and n_frf is the number of DoFs.
    """

    omega: FloatArray  # (n_rows,) in `unit`
    reference: IntArray  # (n_rows,) which one
    n_references: int
    response: ComplexArray  # (n_rows, n_frf)
    weight: FloatArray  # (n_rows, n_frf) one over E|error|^2, 0 for a line not used
    unit: float  # rad/s
    size: FloatArray  # (n_frf,) m/N, the unit of each response
    beyond: tuple[float, ...] = ()  # in `unit`, poles held above the range

    def rows(self, block: slice) -> Rows:
        """Return some of the rows."""
        return Rows(self.omega[block], self.reference[block], self.n_references)

    @property
    def n_residuals(self) -> int:
        """How many columns the residuals have."""
        return self.n_references * (4 + 2 * len(self.beyond))


@dataclass(frozen=True, eq=False)
class Linear:
    """What is linear in the unknowns, with the modes' parameters held."""

    coefficients: FloatArray  # (n_frf, n_columns) those of the columns
    inverse: FloatArray  # (n_frf, n_columns, n_columns) of the columns' weighted products
    mixed: FloatArray  # (n_frf, n_columns, n_slopes) coefficients of the slopes' columns in the columns
    beside: FloatArray  # (n_frf, n_slopes, n_slopes) weighted products of what the columns cannot mimic
    gradient: FloatArray  # (n_frf, n_slopes) products of that with the residual
    misfit: FloatArray  # (n_frf,) weighted sum of squared residuals


def scaled(omega: FloatArray, response: ComplexArray, weight: FloatArray, n_references: int = 1) -> Scaled:
    """Return the lines on scales of order one; an FRF without any weight becomes zero.

    Parameters
    ----------
    omega
        (n_lines,) rad/s, above 0.
    response, weight
        (n_lines, n_frf) m/N and one over E|error|^2, DoF by DoF.
    n_references
        That share the shapes of modes; 1 where each FRF has modal constants of its own.
    """
    beyond = BEYOND if disturbed(omega) else ()
    reference = np.tile(np.arange(n_references), len(omega))
    omega = omega.repeat(n_references)
    response, weight = below_one_another(response, n_references), below_one_another(weight, n_references)
    used = weight > 0
    size = np.sqrt((np.where(used, np.abs(response), 0.0) ** 2).mean(axis=0))
    size = np.where(size > 0, size, 1.0)
    unit = float(omega.max())
    heard = np.asarray(np.where(used, response, 0) / size, complex)
    return Scaled(omega / unit, reference, n_references, heard, weight * size**2, unit, size, beyond)


def below_one_another(values: NDArray[Number], n_references: int) -> NDArray[Number]:
    """Return (n_lines n_references, n_dof) of values (n_lines, n_dof n_references)."""
    apart = values.reshape(len(values), -1, n_references)
    return apart.transpose(0, 2, 1).reshape(len(values) * n_references, -1)


def disturbed(omega: FloatArray) -> bool:
    """Return whether modes beyond a range are no constant in it, and it has the lines to tell."""
    return bool(omega.min() < WIDE * omega.max() and len(omega) > MANY)


def solve_linear(lines: Scaled, basis: ModalBasis, parameters: FloatArray) -> Linear:
    """Return the linear unknowns of every FRF, and how the misfit changes with the parameters.

    Normal equations with columns of unit length, refined once by the residual itself: what was lost by
    squaring comes back.

    Parameters
    ----------
    parameters
        (n_modes, n_parameters) on the scale of `lines`.
    """
    n_columns = 2 * len(parameters) + lines.n_residuals
    products, against = _products(lines, basis, parameters)
    length = np.sqrt(np.maximum(np.einsum("jii->ji", products), TINY))
    products /= length[:, :, None] * length[:, None, :]
    own = products[:, :n_columns, :n_columns]
    own[:, np.arange(n_columns), np.arange(n_columns)] += RIDGE + (length[:, :n_columns] <= TINY**0.5)
    inverse = np.linalg.inv(own)
    mixed = inverse @ products[:, :n_columns, n_columns:]
    beside = products[:, n_columns:, n_columns:] - products[:, n_columns:, :n_columns] @ mixed
    scale, slope_scale = length[:, :n_columns], length[:, n_columns:]
    coefficients = np.einsum("jkl,jl->jk", inverse, against / scale) / scale
    left, _ = _residual(lines, basis, parameters, coefficients)
    refined = np.einsum("jkl,jl->jk", inverse, left[:, :n_columns] / scale)
    coefficients = coefficients + refined / scale
    left, misfit = _residual(lines, basis, parameters, coefficients)
    gradient = left[:, n_columns:] - slope_scale * np.einsum("jks,jk->js", mixed, left[:, :n_columns] / scale)
    return Linear(
        coefficients,
        inverse / (scale[:, :, None] * scale[:, None, :]),
        mixed * slope_scale[:, None, :] / scale[:, :, None],
        beside * slope_scale[:, :, None] * slope_scale[:, None, :],
        gradient,
        misfit,
    )


def line_blocks(n_lines: int, width: int) -> Iterator[slice]:
    """Yield stretches of lines, so few that `width` numbers a line fit into a block."""
    step = max(AT_ONCE // max(width, 1), 1)
    for start in range(0, n_lines, step):
        yield slice(start, start + step)


def _products(lines: Scaled, basis: ModalBasis, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return weighted products of all columns and slopes, and of the columns with the responses."""
    n_modes, n_frf = len(parameters), lines.response.shape[1]
    n_columns = 2 * n_modes + lines.n_residuals
    n_all = n_columns + n_modes * basis.turn.shape[2]
    gather = _few if n_frf < n_all else _all_pairs
    products = np.zeros((n_frf, n_all, n_all))
    against = np.zeros((n_frf, n_columns))
    for block in line_blocks(len(lines.omega), n_all * max(n_all // 2, n_frf)):
        columns = all_columns(basis, lines.rows(block), parameters, lines.beyond)
        every = np.concatenate([columns, all_slopes(basis, lines.rows(block), parameters)], axis=1)
        parts = np.concatenate([every.real, every.imag])
        weight = lines.weight[block]
        products += gather(parts, weight)
        weighted = weight * lines.response[block]
        against += np.concatenate([weighted.real, weighted.imag]).T @ parts[:, :n_columns]
    return products, against


def _few(parts: FloatArray, weight: FloatArray) -> FloatArray:
    """Return weighted products of the columns, (n_frf, n, n), by a product a FRF."""
    both = np.concatenate([weight, weight]).T[:, None, :]
    return np.asarray((both * parts.T) @ parts)


def _all_pairs(parts: FloatArray, weight: FloatArray) -> FloatArray:
    """Return the same by one product for all FRFs, each pair of columns formed once."""
    n = parts.shape[1]
    first, second = np.triu_indices(n)
    n_lines = len(weight)
    pairs = parts[:n_lines, first] * parts[:n_lines, second]
    pairs += parts[n_lines:, first] * parts[n_lines:, second]
    half = weight.T @ pairs
    products = np.empty((weight.shape[1], n, n))
    products[:, first, second] = half
    products[:, second, first] = half
    return products


def _residual(
    lines: Scaled, basis: ModalBasis, parameters: FloatArray, coefficients: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the residual's products with all columns and slopes (n_frf, n), and its square (n_frf,)."""
    n_modes, n_frf = len(parameters), len(coefficients)
    n_columns = coefficients.shape[1]
    sums = np.zeros((n_frf, n_columns + n_modes * basis.turn.shape[2]))
    square = np.zeros(n_frf)
    for block in line_blocks(len(lines.omega), sums.shape[1] + 4 * n_frf):
        columns = all_columns(basis, lines.rows(block), parameters, lines.beyond)
        every = np.concatenate([columns, all_slopes(basis, lines.rows(block), parameters)], axis=1)
        left = lines.response[block] - columns @ coefficients.T
        weighted = lines.weight[block] * left
        square += (weighted * left.conj()).real.sum(axis=0)
        sums += weighted.real.T @ every.real + weighted.imag.T @ every.imag
    return sums, square
