"""A fit on scales of order one in physical units, with what its errors are."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.modal_covariance import Uncertainty
from modallab.extraction.multi_mode.mode_selection import NEAR
from modallab.extraction.multi_mode.participation import SharedShapeBasis
from modallab.extraction.multi_mode.pole_basis import PoleBasis
from modallab.extraction.multi_mode.variable_projection import Linear, Scaled

TINY = 1e-300


def to_physical_units(
    lines: Scaled, basis: PoleBasis, parameters: FloatArray, linear: Linear, known: Uncertainty
) -> ModalFit:
    """Return the fit in physical units; parameters as of the fit."""
    loss_factor, slope = basis.loss_factor(parameters)
    frequency = lines.unit * np.sqrt(parameters[:, 0]) / (2 * np.pi)
    n = len(parameters)
    slopes = np.zeros((2 * n, *parameters.shape))
    modes = np.arange(n)
    slopes[modes, modes, 0] = frequency / (2 * parameters[:, 0])
    slopes[n + modes, modes, :2] = slope
    by = slopes.reshape(2 * n, -1)
    scale = _scale(lines)
    constant, held, moved = _constants(basis, parameters, linear, known)
    residuals = linear.coefficients[:, 2 * n :].reshape(len(scale), -1)
    above, below = residuals[:, 0] + 1j * residuals[:, 1], residuals[:, 2] + 1j * residuals[:, 3]
    reach = basis.participation(parameters) if isinstance(basis, SharedShapeBasis) else None
    covariance = by @ known.parameters @ by.T
    return ModalFit(
        eigenvalue=(2 * np.pi * frequency) ** 2 * (1 + 1j * loss_factor),
        modal_constant=constant * scale,
        residuals=np.stack([below * scale, above * scale / lines.unit**2]),
        eigenvalue_covariance=covariance,
        modal_constant_error=np.sqrt(held + moved) * scale,
        misfit=known.misfit.repeat(lines.n_references),
        common=known.common,
        participation=reach,
        clear=None
        if reach is None
        else _clear(constant, np.sqrt(held), frequency, loss_factor * frequency, reach),
        held_error=None if reach is None else np.sqrt(held) * scale,
    )


def constants(lines: Scaled, basis: PoleBasis, parameters: FloatArray, linear: Linear) -> ComplexArray:
    """Return the modal constants in physical units, (n_modes, n_frf) 1/kg."""
    parts = _parts(basis, parameters, linear)[0]
    return np.asarray((parts[..., 0] + 1j * parts[..., 1]).reshape(len(parameters), -1) * _scale(lines))


def _scale(lines: Scaled) -> FloatArray:
    return (lines.unit**2 * lines.size).repeat(lines.n_references)


def _parts(basis: PoleBasis, parameters: FloatArray, linear: Linear) -> tuple[FloatArray, FloatArray]:
    """Return both parts of the modal constants, (n_modes, n_dof, n_ref, 2), and the coefficients in them."""
    coefficients = linear.coefficients[:, : 2 * len(parameters)].reshape(-1, len(parameters), 2)
    return np.einsum("rmck,jrk->rjmc", basis.constant(parameters), coefficients), coefficients


def _constants(
    basis: PoleBasis, parameters: FloatArray, linear: Linear, known: Uncertainty
) -> tuple[ComplexArray, FloatArray, FloatArray]:
    """Return modal constants and two parts of their variance, all (n_modes, n_frf).

    The variance with the parameters held, and that which the parameters bring in.
    """
    n_modes, n_parameters = parameters.shape
    per = basis.constant(parameters)
    parts, coefficients = _parts(basis, parameters, linear)
    held = np.einsum("rmck,jrkl,rmcl->rjm", per, known.held, per, optimize=True) / 2
    follow = np.einsum("rmck,jrkp->rjmcp", per, known.through, optimize=True)
    if (slopes := basis.constant_slopes(parameters)) is not None:
        own = follow.reshape(*follow.shape[:4], n_modes, n_parameters)
        modes = np.arange(n_modes)
        own[modes, :, :, :, modes] += np.einsum("rmpck,jrk->rjmcp", slopes, coefficients, optimize=True)
    moved = np.einsum("rjmcp,pq,rjmcq->rjm", follow, known.parameters, follow, optimize=True) / 2
    constant, held, moved = (
        values.reshape(n_modes, -1) for values in (parts[..., 0] + 1j * parts[..., 1], held, moved)
    )
    return constant, np.maximum(held, 0.0), np.maximum(moved, 0.0)


def _clear(
    constant: ComplexArray,
    error: FloatArray,
    frequency: FloatArray,
    width: FloatArray,
    reach: ComplexArray,
) -> FloatArray:
    """Return by how many standard errors FRFs show each mode beside those near it, (n_modes,).

    Of coincident modes the shapes may be any of the plane that they span, so that their errors have no
    bound; but a plane it is only if neither shapes nor participations of the two are the same. What counts is
    that part of a mode's constants which no shape and no participation of the others has.

    Parameters
    ----------
    error
        (n_modes, n_frf) of either part of the constants, poles and participations held.
    """
    clear, by_reference = np.empty(len(frequency)), constant.reshape(len(frequency), -1, reach.shape[1])
    for r in range(len(frequency)):
        near = np.abs(frequency - frequency[r]) < NEAR * np.maximum(width, width[r])
        near[r] = False
        strongest = np.abs(reach[near]).argmax(axis=1)
        shapes = by_reference[near, :, strongest].T
        across = _beside(by_reference[r], shapes)
        alone = _beside(across.T, reach[near].T).T
        clear[r] = (np.abs(alone).ravel() / np.maximum(error[r], TINY)).max()
    return clear


def _beside(values: ComplexArray, others: ComplexArray) -> ComplexArray:
    """Return what no combination of the columns of `others` makes of the columns of `values`."""
    if not others.size:
        return values
    return np.asarray(values - others @ np.linalg.lstsq(others, values)[0])
