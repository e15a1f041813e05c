"""Conversion of a fit on normalised scales to physical units."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.extraction.multi_mode.chart_settings import SELECTION
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.modal_covariance import Uncertainty
from modallab.extraction.multi_mode.participation import SharedShapeBasis
from modallab.extraction.multi_mode.pole_basis import PoleBasis
from modallab.extraction.multi_mode.variable_projection import LinearSolution, ScaledLines


def to_physical_units(
    lines: ScaledLines,
    basis: PoleBasis,
    parameters: FloatArray,
    linear: LinearSolution,
    covariances: Uncertainty,
) -> ModalFit:
    """Return the fit in physical units; parameters as of the fit."""
    loss_factor, slope = basis.loss_factor(parameters)
    frequency = lines.unit * np.sqrt(parameters[:, 0]) / (2 * np.pi)
    n = len(parameters)
    slopes = np.zeros((2 * n, *parameters.shape))
    modes = np.arange(n)
    slopes[modes, modes, 0] = frequency / (2 * parameters[:, 0])
    slopes[n + modes, modes, :2] = slope
    jacobian = slopes.reshape(2 * n, -1)
    scale = _scale(lines)
    constant, conditional, propagated = _constants(basis, parameters, linear, covariances)
    residuals = linear.coefficients[:, 2 * n :].reshape(len(scale), -1)
    stiffness_line, mass_line, *fixed = (residuals[:, 0::2] + 1j * residuals[:, 1::2]).T
    participation = basis.participation(parameters) if isinstance(basis, SharedShapeBasis) else None
    covariance = jacobian @ covariances.parameters @ jacobian.T
    return ModalFit(
        eigenvalue=(2 * np.pi * frequency) ** 2 * (1 + 1j * loss_factor),
        modal_constant=constant * scale,
        residuals=np.stack([mass_line * scale, stiffness_line * scale / lines.unit**2]),
        eigenvalue_covariance=covariance,
        modal_constant_error=np.sqrt(conditional + propagated) * scale,
        misfit=covariances.misfit.repeat(lines.n_references),
        common_noise=covariances.common_noise,
        participation=participation,
        significance=None
        if participation is None
        else _significance(constant, np.sqrt(conditional), frequency, loss_factor * frequency, participation),
        conditional_error=None if participation is None else np.sqrt(conditional) * scale,
        fixed_eigenvalue=(np.array(lines.fixed_poles) * lines.unit) ** 2 if fixed else None,
        fixed_constant=np.asarray(np.array(fixed) * scale, complex) if fixed else None,
    )


def constants(
    lines: ScaledLines, basis: PoleBasis, parameters: FloatArray, linear: LinearSolution
) -> ComplexArray:
    """Return the modal constants in physical units, (n_modes, n_frf) 1/kg."""
    parts = _parts(basis, parameters, linear)[0]
    return np.asarray((parts[..., 0] + 1j * parts[..., 1]).reshape(len(parameters), -1) * _scale(lines))


def _scale(lines: ScaledLines) -> FloatArray:
    return (lines.unit**2 * lines.size).repeat(lines.n_references)


def _parts(basis: PoleBasis, parameters: FloatArray, linear: LinearSolution) -> tuple[FloatArray, FloatArray]:
    """Return both parts of the modal constants, (n_modes, n_dof, n_ref, 2), and the coefficients in them."""
    coefficients = linear.coefficients[:, : 2 * len(parameters)].reshape(-1, len(parameters), 2)
    return np.einsum("rmck,jrk->rjmc", basis.constant(parameters), coefficients), coefficients


def _constants(
    basis: PoleBasis, parameters: FloatArray, linear: LinearSolution, covariances: Uncertainty
) -> tuple[ComplexArray, FloatArray, FloatArray]:
    """Return modal constants and two parts of their variance, all (n_modes, n_frf).

    The first part is the variance for fixed parameters, the second that by the parameters.
    """
    n_modes, n_parameters = parameters.shape
    per = basis.constant(parameters)
    parts, coefficients = _parts(basis, parameters, linear)
    conditional = np.einsum("rmck,jrkl,rmcl->rjm", per, covariances.conditional, per, optimize=True) / 2
    follow = np.einsum("rmck,jrkp->rjmcp", per, covariances.sensitivity, optimize=True)
    if (slopes := basis.constant_slopes(parameters)) is not None:
        mode_sensitivity = follow.reshape(*follow.shape[:4], n_modes, n_parameters)
        modes = np.arange(n_modes)
        mode_sensitivity[modes, :, :, :, modes] += np.einsum(
            "rmpck,jrk->rjmcp", slopes, coefficients, optimize=True
        )
    propagated = np.einsum("rjmcp,pq,rjmcq->rjm", follow, covariances.parameters, follow, optimize=True) / 2
    if covariances.cross is not None:
        propagated += np.einsum("rmck,jrkp,rjmcp->rjm", per, covariances.cross, follow, optimize=True)
    constant, conditional, propagated = (
        values.reshape(n_modes, -1)
        for values in (parts[..., 0] + 1j * parts[..., 1], conditional, propagated)
    )
    # A negative variance is rounding of its size, where poles nearly depend on each other.
    conditional = np.maximum(conditional, 0.0)
    return constant, conditional, np.where(propagated < -conditional, -propagated, propagated)


def _significance(
    constant: ComplexArray,
    error: FloatArray,
    frequency: FloatArray,
    width: FloatArray,
    participation: ComplexArray,
) -> FloatArray:
    """Return the standard errors by which FRFs show each mode beside neighbouring modes, (n_modes,).

    The shapes of coincident modes are arbitrary in the plane that they span, with unbounded errors; yet they
    span a plane only if neither their shapes nor their participation factors are equal. The significance is
    that of the part of a mode's constants orthogonal to shapes and participation factors of the others.

    Parameters
    ----------
    error
        (n_modes, n_frf) of real and imaginary part of the constants, for known poles and participation
        factors.
    """
    significance, by_reference = (
        np.empty(len(frequency)),
        constant.reshape(len(frequency), -1, participation.shape[1]),
    )
    for r in range(len(frequency)):
        near = np.abs(frequency - frequency[r]) < SELECTION.pair_distance * np.maximum(width, width[r])
        near[r] = False
        strongest = np.abs(participation[near]).argmax(axis=1)
        shapes = by_reference[near, :, strongest].T
        across = _orthogonal_part(by_reference[r], shapes)
        distinct = _orthogonal_part(across.T, participation[near].T).T
        significance[r] = (np.abs(distinct).ravel() / np.maximum(error[r], SAFE_DIVISOR)).max()
    return significance


def _orthogonal_part(values: ComplexArray, columns: ComplexArray) -> ComplexArray:
    """Return the part of `values` orthogonal to `columns`."""
    if not columns.size:
        return values
    return np.asarray(values - columns @ np.linalg.lstsq(columns, values)[0])
