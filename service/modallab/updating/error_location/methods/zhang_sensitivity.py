"""Zhang's sensitivity method: coefficients with a large change and a large weight."""

import numpy as np

from modallab.updating.error_location.method import (
    LOCATORS,
    ErrorLocationMethod,
    LinearLocation,
    LinearProblem,
)
from modallab.updating.error_location.settings import ERROR_LOCATION
from modallab.updating.solve import balanced_step


def zhang_sensitivity(problem: LinearProblem, *, threshold: float, jump: float) -> LinearLocation:
    """Coefficients that a linear step moves far, unless hardly anything feels them.

    dp = S^+ delta and e_j = |S_j dp_j| / |delta| [2.30]: a large dp_j with a small e_j comes from a low
    sensitivity and not from an error. All coefficients are solved for at once, so that where columns are
    alike large ones of opposite sign stand for each other, and errors drown in them. Zhang's first
    method, as the 1992 thesis, section 2.3.3, gives it.
    """
    step = balanced_step(problem.sensitivity, problem.difference, np.ones(len(problem.difference)), jump=jump)
    total_norm = float(np.linalg.norm(problem.difference))
    weight = np.linalg.norm(problem.sensitivity * step.parameters, axis=0) / (total_norm or 1.0)
    suspected = (np.abs(step.parameters) > threshold) & (
        weight > ERROR_LOCATION.min_weight * weight.max(initial=0.0)
    )
    return LinearLocation(step.parameters, weight, suspected, np.zeros(0), step.rank, step.condition_number)


LOCATORS.register("zhang_sensitivity")(ErrorLocationMethod(zhang_sensitivity))
