"""Weighted sums over the lines that a fit of all modes in all FRFs needs, and its linear unknowns."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.multi_mode.pole_basis import PoleBasis, all_columns, all_slopes
from modallab.extraction.multi_mode.reference_mixing import ReferenceMixing, reference_mixing
from modallab.extraction.multi_mode.weighted_products import weighted_products

Number = TypeVar("Number", bound=np.generic)

AT_ONCE = 2**22  # numbers in a block of products, 32 MB
# A range so wide, of so many lines, is disturbed by how modes beyond it differ from a constant, and can tell.
WIDE, MANY = 0.5, 64
BEYOND = (1.5,)  # with the constant, all that lies above to 3 %, but for the mode next to the range
TINY = 1e-300
RIDGE = 1e-13  # of columns of unit length: keeps what rounding alone parts from running away


@dataclass(frozen=True, eq=False)
class Scaled:
    """Lines on scales of order one: omega up to 1, the weighted rms of each DoF's FRFs 1.

    FRFs are counted DoF by DoF, at each of them reference by reference. Those of several references may
    share their modes' shapes: then the unknowns are those of a DoF, otherwise those of an FRF.
    """

    omega: FloatArray  # (n_lines,) in `unit`
    n_references: int  # that share shapes
    response: ComplexArray  # (n_lines, n_frf)
    weight: FloatArray  # (n_lines, n_frf) one over E|error|^2, 0 for a line not used
    unit: float  # rad/s
    size: FloatArray  # (n_dof,) m/N, the unit of each response
    beyond: tuple[float, ...] = ()  # in `unit`, poles held above the range

    def mixture(self, basis: PoleBasis, parameters: FloatArray) -> ReferenceMixing:
        """Return how a DoF's FRFs follow from those of each reference."""
        return reference_mixing(basis, parameters, 4 + 2 * len(self.beyond))


@dataclass(frozen=True, eq=False)
class Linear:
    """What is linear in the unknowns, with the modes' parameters held."""

    coefficients: FloatArray  # (n_dof, n_columns) those of the columns
    inverse: FloatArray  # (n_dof, n_columns, n_columns) of the columns' weighted products
    mixed: FloatArray  # (n_dof, n_columns, n_slopes) coefficients of the slopes' columns in the columns
    beside: FloatArray  # (n_dof, n_slopes, n_slopes) weighted products of what the columns cannot mimic
    gradient: FloatArray  # (n_dof, n_slopes) products of that with the residual
    misfit: FloatArray  # (n_dof,) weighted sum of squared residuals


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
    used = weight > 0
    power = below_one_another(np.where(used, np.abs(response), 0.0) ** 2, n_references).mean(axis=0)
    size = np.sqrt(np.where(power > 0, power, 1.0))
    unit, of_frf = float(omega.max()), size.repeat(n_references)
    heard = np.asarray(np.where(used, response, 0) / of_frf, complex)
    beyond = BEYOND if disturbed(omega) else ()
    return Scaled(omega / unit, n_references, heard, weight * of_frf**2, unit, size, beyond)


def below_one_another(values: NDArray[Number], n_references: int) -> NDArray[Number]:
    """Return (n_lines n_references, n_dof) of values (n_lines, n_dof n_references)."""
    apart = values.reshape(len(values), -1, n_references)
    return apart.transpose(0, 2, 1).reshape(len(values) * n_references, -1)


def disturbed(omega: FloatArray) -> bool:
    """Return whether modes beyond a range are no constant in it, and it has the lines to tell."""
    return bool(omega.min() < WIDE * omega.max() and len(omega) > MANY)


def solve_linear(lines: Scaled, basis: PoleBasis, parameters: FloatArray) -> Linear:
    """Return the linear unknowns of every FRF, and how the misfit changes with the parameters.

    Normal equations with columns of unit length, refined once by the residual itself: what was lost by
    squaring comes back.

    Parameters
    ----------
    parameters
        (n_modes, n_parameters) on the scale of `lines`.
    """
    mix = lines.mixture(basis, parameters)
    n_columns = mix.n_all
    each, alone = _products(lines, basis, parameters, mix)
    products, against = mix.products(each), mix.sums(alone)
    length = np.sqrt(np.maximum(np.einsum("jii->ji", products), TINY))
    products /= length[:, :, None] * length[:, None, :]
    own = products[:, :n_columns, :n_columns]
    own[:, np.arange(n_columns), np.arange(n_columns)] += RIDGE + (length[:, :n_columns] <= TINY**0.5)
    inverse = np.linalg.inv(own)
    mixed = inverse @ products[:, :n_columns, n_columns:]
    beside = products[:, n_columns:, n_columns:] - products[:, n_columns:, :n_columns] @ mixed
    scale, slope_scale = length[:, :n_columns], length[:, n_columns:]
    coefficients = np.einsum("jkl,jl->jk", inverse, against / scale) / scale
    left, _ = _residual(lines, basis, parameters, mix, coefficients)
    refined = np.einsum("jkl,jl->jk", inverse, left[:, :n_columns] / scale)
    coefficients = coefficients + refined / scale
    left, misfit = _residual(lines, basis, parameters, mix, coefficients)
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


def _products(
    lines: Scaled, basis: PoleBasis, parameters: FloatArray, mix: ReferenceMixing
) -> tuple[FloatArray, FloatArray]:
    """Return weighted products of an FRF's columns and slopes, and of the columns with the responses."""
    n_frf, n_every = lines.response.shape[1], mix.n_every
    products = np.zeros((n_frf, n_every, n_every))
    against = np.zeros((n_frf, mix.n_each))
    for block in line_blocks(len(lines.omega), 4 * (n_every + n_frf)):
        every = columns_and_slopes(lines, basis, parameters, block)
        weight = lines.weight[block]
        products += weighted_products(every, weight, turned=basis.turned)
        weighted, columns = weight * lines.response[block], every[:, : mix.n_each]
        against += weighted.real.T @ columns.real + weighted.imag.T @ columns.imag
    return products, against


def columns_and_slopes(lines: Scaled, basis: PoleBasis, parameters: FloatArray, block: slice) -> ComplexArray:
    """Return those of an FRF at some lines, (n_lines, n)."""
    omega = lines.omega[block]
    columns = all_columns(basis, omega, parameters, lines.beyond)
    return np.concatenate([columns, all_slopes(basis, omega, parameters)], axis=1)


def _residual(
    lines: Scaled, basis: PoleBasis, parameters: FloatArray, mix: ReferenceMixing, coefficients: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the residual's products with all columns and slopes (n_dof, n), and its square (n_dof,)."""
    n_frf = lines.response.shape[1]
    of_frf = mix.coefficients(coefficients).T
    sums, square = np.zeros((n_frf, mix.n_every)), np.zeros(n_frf)
    for block in line_blocks(len(lines.omega), mix.n_every + 4 * n_frf):
        every = columns_and_slopes(lines, basis, parameters, block)
        left = lines.response[block] - every[:, : mix.n_each] @ of_frf
        weighted = lines.weight[block] * left
        square += (weighted * left.conj()).real.sum(axis=0)
        sums += weighted.real.T @ every.real + weighted.imag.T @ every.imag
    return mix.sums(sums), square.reshape(len(coefficients), -1).sum(axis=1)
