"""Variable projection: weighted sums over lines and the linear unknowns of a fit of all modes."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import EIGENVALUE_ROUNDING, SAFE_DIVISOR
from modallab.extraction.multi_mode.fit_settings import PROJECTION
from modallab.extraction.multi_mode.line_groups import LineGroups, proportional_groups, similar_groups
from modallab.extraction.multi_mode.pole_basis import PoleBasis, all_columns, all_slopes
from modallab.extraction.multi_mode.reference_mixing import ReferenceMixing, reference_mixing
from modallab.extraction.multi_mode.weighted_products import grouped_products, weighted_products
from modallab.extraction.preprocessing.noise_model import INDEPENDENT_LINES, NoiseModel

Number = TypeVar("Number", bound=np.generic)


@dataclass(frozen=True, eq=False)
class ScaledLines:
    """Lines scaled to order one: largest omega 1, rms of the FRFs of each DoF 1.

    FRFs are ordered by DoF, then by reference. If the FRFs of several references share the shapes of modes,
    the unknowns belong to a DoF, otherwise to an FRF.
    """

    omega: FloatArray
    """(n_lines,) in `unit`."""
    n_references: int
    """Number of references that share shapes."""
    response: ComplexArray
    """(n_lines, n_frf) scaled responses."""
    weight: FloatArray
    """(n_lines, n_frf) one over E|error|^2, 0 for a line not used."""
    unit: float
    """rad/s, unit of omega."""
    size: FloatArray
    """(n_dof,) m/N, unit of the responses of each DoF."""
    groups: LineGroups | None = None
    """Groups of lines with proportional weights; None where they would not save time."""
    fixed_poles: tuple[float, ...] = ()
    """In `unit`, fixed poles above the range."""
    noise: NoiseModel = INDEPENDENT_LINES
    """Common errors of the lines."""

    def reference_mixing(self, basis: PoleBasis, parameters: FloatArray) -> ReferenceMixing:
        """Return the linear map between sums of single FRFs and of all FRFs of a DoF."""
        return reference_mixing(basis, parameters, 4 + 2 * len(self.fixed_poles))


@dataclass(frozen=True, eq=False)
class LinearSolution:
    """Solution of the linear unknowns at given parameters of the modes."""

    coefficients: FloatArray
    """(n_dof, n_columns) coefficients of the columns."""
    inverse: FloatArray
    """(n_dof, n_columns, n_columns) inverse normal matrix of the columns."""
    mixed: FloatArray
    """(n_dof, n_columns, n_slopes) coefficients of the projection of slope columns onto the columns."""
    projected: FloatArray
    """(n_dof, n_slopes, n_slopes) weighted products of the slope columns orthogonal to the columns."""
    gradient: FloatArray
    """(n_dof, n_slopes) weighted products of these with the residual."""
    misfit: FloatArray
    """(n_dof,) weighted sum of squared residuals."""


def scale_lines(
    omega: FloatArray,
    response: ComplexArray,
    weight: FloatArray,
    n_references: int = 1,
    noise: NoiseModel = INDEPENDENT_LINES,
) -> ScaledLines:
    """Return the lines on scales of order one; an FRF without any weight becomes zero.

    Parameters
    ----------
    omega
        (n_lines,) rad/s, above 0.
    response, weight
        (n_lines, n_frf) m/N and one over E|error|^2, DoF by DoF.
    n_references
        Number of references that share the shapes of modes; 1 if each FRF has its own modal constants.
    noise
        Common errors of the lines.
    """
    used = weight > 0
    power = stack_references(np.where(used, np.abs(response), 0.0) ** 2, n_references).mean(axis=0)
    size = np.sqrt(np.where(power > 0, power, 1.0))
    unit, of_frf = float(omega.max()), size.repeat(n_references)
    response_scaled = np.asarray(np.where(used, response, 0) / of_frf, complex)
    fixed_poles = PROJECTION.fixed_poles if affected_by_outer_modes(omega) else ()
    weight_scaled = weight * of_frf**2
    groups = proportional_groups(weight_scaled)
    return ScaledLines(
        omega / unit,
        n_references,
        response_scaled,
        weight_scaled,
        unit,
        size,
        groups if groups.worthwhile else None,
        fixed_poles,
        noise,
    )


def with_similar_weights(lines: ScaledLines) -> ScaledLines | None:
    """Return the lines with similar weights that cost less, to start a fit; None where there are none."""
    if lines.groups is not None:
        return None
    groups = similar_groups(lines.weight)
    return replace(lines, weight=groups.weight, groups=groups) if groups.worthwhile else None


def stack_references(values: NDArray[Number], n_references: int) -> NDArray[Number]:
    """Return (n_lines n_references, n_dof) of values (n_lines, n_dof n_references)."""
    by_reference = values.reshape(len(values), -1, n_references)
    return by_reference.transpose(0, 2, 1).reshape(len(values) * n_references, -1)


def affected_by_outer_modes(omega: FloatArray) -> bool:
    """Return whether modes outside a range vary over it, and its lines determine them."""
    return bool(omega.min() < PROJECTION.wide_range * omega.max() and len(omega) > PROJECTION.many_lines)


def solve_linear(lines: ScaledLines, basis: PoleBasis, parameters: FloatArray) -> LinearSolution:
    """Return the linear unknowns of every FRF, and the derivatives of the misfit by the parameters.

    Normal equations with columns of unit length, and one step of iterative refinement by the residual, which
    recovers the precision lost by squaring.

    Parameters
    ----------
    lines, basis
        From `scale_lines`, and of the damping model.
    parameters
        (n_modes, n_parameters) on the scale of `lines`.
    """
    mix = lines.reference_mixing(basis, parameters)
    n_columns = mix.n_dof_columns
    frf_products, frf_sums = _products(lines, basis, parameters, mix)
    products, right_side = mix.products(frf_products), mix.sums(frf_sums)
    length = np.sqrt(np.maximum(np.einsum("jii->ji", products), SAFE_DIVISOR))
    products /= length[:, :, None] * length[:, None, :]
    normal = products[:, :n_columns, :n_columns].copy()
    normal[:, np.arange(n_columns), np.arange(n_columns)] += EIGENVALUE_ROUNDING + (
        length[:, :n_columns] <= SAFE_DIVISOR**0.5
    )
    inverse = np.linalg.inv(normal)
    mixed = inverse @ products[:, :n_columns, n_columns:]
    projected = products[:, n_columns:, n_columns:] - products[:, n_columns:, :n_columns] @ mixed
    scale, slope_scale = length[:, :n_columns], length[:, n_columns:]
    coefficients = (inverse @ (right_side / scale)[:, :, None])[:, :, 0] / scale
    sums, misfit = _residual(lines, basis, parameters, mix, coefficients)
    sums /= length
    refined = (inverse @ sums[:, :n_columns, None])[:, :, 0]
    change = (products[:, :, :n_columns] @ refined[:, :, None])[:, :, 0]
    misfit = misfit - ((2 * sums - change)[:, :n_columns] * refined).sum(axis=1)
    sums -= change
    gradient = slope_scale * (
        sums[:, n_columns:] - (mixed.swapaxes(1, 2) @ sums[:, :n_columns, None])[:, :, 0]
    )
    coefficients = coefficients + refined / scale
    return LinearSolution(
        coefficients,
        inverse / (scale[:, :, None] * scale[:, None, :]),
        mixed * slope_scale[:, None, :] / scale[:, :, None],
        projected * slope_scale[:, :, None] * slope_scale[:, None, :],
        gradient,
        misfit,
    )


def line_blocks(n_lines: int, width: int) -> Iterator[slice]:
    """Yield blocks of lines, sized for `width` numbers for each line in the memory of a block."""
    step = max(PROJECTION.products_in_memory // max(width, 1), 1)
    for start in range(0, n_lines, step):
        yield slice(start, start + step)


def _products(
    lines: ScaledLines, basis: PoleBasis, parameters: FloatArray, mix: ReferenceMixing
) -> tuple[FloatArray, FloatArray]:
    """Return weighted products of an FRF's columns and slopes, and of the columns with the responses."""
    n_frf, n_every = lines.response.shape[1], mix.n_frf_all
    products = np.zeros((n_frf, n_every, n_every))
    right_side = np.zeros((n_frf, mix.n_frf_columns))
    for block in line_blocks(len(lines.omega), 4 * (n_every + n_frf)):
        columns, paired = columns_and_slopes(lines, basis, parameters, block), basis.paired_columns
        products += (
            weighted_products(columns, lines.weight[block], paired_columns=paired)
            if lines.groups is None
            else grouped_products(columns, lines.groups, block.start, paired_columns=paired)
        )
        weighted = _parts(lines.weight[block] * lines.response[block])
        right_side += weighted.T @ _parts(columns[:, : mix.n_frf_columns])
    return products, right_side


def _parts(values: ComplexArray) -> FloatArray:
    """Return the real parts of all lines, then the imaginary parts, (2 n_lines, n)."""
    return np.concatenate([values.real, values.imag])


def columns_and_slopes(
    lines: ScaledLines, basis: PoleBasis, parameters: FloatArray, block: slice
) -> ComplexArray:
    """Return columns and slope columns of an FRF at a block of lines, (n_lines, n)."""
    omega = lines.omega[block]
    columns = all_columns(basis, omega, parameters, lines.fixed_poles)
    return np.concatenate([columns, all_slopes(basis, omega, parameters)], axis=1)


def _residual(
    lines: ScaledLines,
    basis: PoleBasis,
    parameters: FloatArray,
    mix: ReferenceMixing,
    coefficients: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the residual's products with all columns and slopes (n_dof, n), and its square (n_dof,)."""
    n_frf = lines.response.shape[1]
    of_frf = mix.coefficients(coefficients).T
    sums, square = np.zeros((n_frf, mix.n_frf_all)), np.zeros(n_frf)
    for block in line_blocks(len(lines.omega), mix.n_frf_all + 4 * n_frf):
        columns = _parts(columns_and_slopes(lines, basis, parameters, block))
        residual = _parts(lines.response[block]) - columns[:, : mix.n_frf_columns] @ of_frf
        weighted = np.tile(lines.weight[block], (2, 1)) * residual
        square += np.einsum("kj,kj->j", weighted, residual)
        sums += weighted.T @ columns
    return mix.sums(sums), square.reshape(len(coefficients), -1).sum(axis=1)
