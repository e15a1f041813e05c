"""How sure an update is of its coefficients."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.updating.identifiability import Identifiability, identify
from modallab.updating.modal_residuals import ModalResiduals, State
from modallab.updating.solve import balanced_step


@dataclass(frozen=True, eq=False)
class CoefficientCovariance:
    """What the measurement says about the coefficients where they ended."""

    standard_errors: FloatArray | None  # (n_params,), None if there is nothing to judge by
    identifiability: Identifiability


def coefficient_covariance(
    fit: ModalResiduals, state: State, *, jump: float, within: float
) -> CoefficientCovariance:
    """Return standard errors of the coefficients at a state, and what data identify.

    Standard errors are those of the measured frequencies and shapes carried through the last step,
    where the modal model states all of them; else every balanced row is taken to be as uncertain
    as the rows are far from the updated model, which needs more rows than coefficients. Directions
    beyond the rank are not in them: there the measurement says nothing at all.
    """
    step = balanced_step(fit.sensitivity(state), state.difference, state.size, jump=jump)
    rows = _errors(fit, state, step.rank)
    told = identify(
        fit.parameterisation, state.values, step, state.difference / state.size, rows, within=within
    )
    errors = None if rows is None else np.asarray(np.sqrt(step.inverse**2 @ rows**2))
    return CoefficientCovariance(errors, told)


def _errors(fit: ModalResiduals, state: State, rank: int) -> FloatArray | None:
    """Return the standard errors of balanced rows (n_rows,)."""
    stated = fit.errors(state)
    if stated is not None:
        return stated
    spare = len(state.difference) - rank
    if spare == 0:
        return None
    scatter = np.sqrt(((state.difference / state.size) ** 2).sum() / spare)
    return np.full(len(state.difference), scatter)
