"""Covariance of coefficients after a two-stage update."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.updating.identifiability import Identifiability, identify
from modallab.updating.modal_residuals import ModalResiduals, ModelState
from modallab.updating.solve import balanced_step


@dataclass(frozen=True, eq=False)
class CoefficientCovariance:
    """Standard errors and identifiability of the coefficients at the end."""

    standard_errors: FloatArray | None
    """(n_params,), None without an error estimate."""
    identifiability: Identifiability


def coefficient_covariance(
    fit: ModalResiduals, state: ModelState, *, jump: float, within: float
) -> CoefficientCovariance:
    """Return standard errors of the coefficients at a state, and their identifiability.

    The stated errors of frequencies and shapes are propagated through the last step. Without stated errors
    every balanced row has the residual standard deviation, which needs more rows than coefficients.
    Directions beyond the rank are left out: the measurement does not determine them.
    """
    step = balanced_step(fit.sensitivity(state), state.difference, state.size, jump=jump)
    row_errors = _row_errors(fit, state, step.rank)
    identifiability = identify(
        fit.parameterisation, state.values, step, state.difference / state.size, row_errors, within=within
    )
    errors = None if row_errors is None else np.asarray(np.sqrt(step.inverse**2 @ row_errors**2))
    return CoefficientCovariance(errors, identifiability)


def _row_errors(fit: ModalResiduals, state: ModelState, rank: int) -> FloatArray | None:
    """Return the standard errors of balanced rows (n_rows,), None without degrees of freedom."""
    stated = fit.errors(state)
    if stated is not None:
        return stated
    degrees_of_freedom = len(state.difference) - rank
    if degrees_of_freedom == 0:
        return None
    scatter = np.sqrt(((state.difference / state.size) ** 2).sum() / degrees_of_freedom)
    return np.full(len(state.difference), scatter)
