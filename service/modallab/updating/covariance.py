"""How sure an update is of its coefficients."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.updating.identifiability import Identifiability, identify
from modallab.updating.modal_residuals import ModalResiduals, ModelState
from modallab.updating.solve import balanced_step


@dataclass(frozen=True, eq=False)
class CoefficientCovariance:
    """What the measurement says about the coefficients where they ended."""

    standard_errors: FloatArray | None  # (n_params,), None if there is nothing to judge by
    identifiability: Identifiability


def coefficient_covariance(
    fit: ModalResiduals, state: ModelState, *, jump: float, within: float
) -> CoefficientCovariance:
    """Return standard errors of the coefficients at a state, and what data identify.

    Standard errors are those of the measured frequencies and shapes carried through the last step,
    where the modal model states all of them; else every balanced row is taken to be as uncertain
    as the rows are far from the updated model, which needs more rows than coefficients. Directions
    beyond the rank are not in them: there the measurement says nothing at all.
    """
    step = balanced_step(fit.sensitivity(state), state.difference, state.size, jump=jump)
    row_errors = _row_errors(fit, state, step.rank)
    identifiability = identify(
        fit.parameterisation, state.values, step, state.difference / state.size, row_errors, within=within
    )
    errors = None if row_errors is None else np.asarray(np.sqrt(step.inverse**2 @ row_errors**2))
    return CoefficientCovariance(errors, identifiability)


def _row_errors(fit: ModalResiduals, state: ModelState, rank: int) -> FloatArray | None:
    """Return the standard errors of balanced rows (n_rows,)."""
    stated = fit.errors(state)
    if stated is not None:
        return stated
    degrees_of_freedom = len(state.difference) - rank
    if degrees_of_freedom == 0:
        return None
    scatter = np.sqrt(((state.difference / state.size) ** 2).sum() / degrees_of_freedom)
    return np.full(len(state.difference), scatter)
