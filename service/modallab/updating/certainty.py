"""How sure an update is of its coefficients."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.updating.fit import Fit, State
from modallab.updating.solve import Step, balanced_step


@dataclass(frozen=True, eq=False)
class Certainty:
    """What the measurement says about the coefficients where they ended."""

    rank: int
    condition_number: float
    standard_errors: FloatArray | None  # (n_params,), None if there is nothing to judge by


def certainty(fit: Fit, state: State, *, jump: float) -> Certainty:
    """Return rank, condition number and standard errors at a state.

    Standard errors are those of the measured frequencies and shapes carried through the last step,
    where the modal model states all of them; else every balanced row is taken to be as uncertain
    as the rows are far from the updated model, which needs more rows than coefficients. Directions
    beyond the rank are not in them: there the measurement says nothing at all.
    """
    step = balanced_step(fit.sensitivity(state), state.difference, state.size, jump=jump)
    return Certainty(step.rank, step.condition_number, _standard_errors(fit, state, step))


def _standard_errors(fit: Fit, state: State, step: Step) -> FloatArray | None:
    stated = fit.target.errors
    if stated is not None:
        return np.asarray(np.sqrt(step.inverse**2 @ stated**2))
    spare = len(state.difference) - step.rank
    if spare == 0:
        return None
    scatter = np.sqrt(((state.difference / state.size) ** 2).sum() / spare)
    return np.asarray(scatter * np.sqrt((step.inverse**2).sum(axis=1)))
