"""The few coefficients that explain most."""

import numpy as np

from modallab.updating.error_location.method import LOCATORS, LinearLocation, LinearProblem
from modallab.updating.solve import balanced_step

WORTH = 0.05  # of what is left of the difference: a coefficient that takes less away is no suspect
NOTHING = 1e-6  # balanced difference that rounding of eigenvalues makes
ALIKE = 1e-6  # part of a column that the chosen ones do not have, below which it says nothing new


@LOCATORS.register("zhang_subspace")
def zhang_subspace(problem: LinearProblem, *, threshold: float, jump: float) -> LinearLocation:
    """The coefficients of the subspace that, grown one by one, leaves least of the difference.

    min |delta - S^k dp^k| [2.31] over k = 1, 2, ...: each time the coefficient joins that leaves least with
    all chosen before solved for again, until the next would take away less than a twentieth. Those that end
    within the threshold of 1 are let go again. Zhang's second method, as the 1992 thesis, section 2.3.3,
    gives it; the search is orthogonal least squares: Chen, S., Billings, S. A. and Luo, W. (1989),
    International Journal of Control 50(5), 1873-1896.
    """
    sensitivity, left = problem.sensitivity.copy(), problem.difference.copy()
    sizes = np.linalg.norm(sensitivity, axis=0)
    whole = float(np.linalg.norm(left))
    chosen: list[int] = []
    remaining: list[float] = []
    rest = whole
    while rest > NOTHING * np.sqrt(len(left)) and len(chosen) < min(sensitivity.shape):
        own = np.linalg.norm(sensitivity, axis=0)
        new = (own > ALIKE * sizes) & ~np.isin(np.arange(len(own)), chosen)
        gain = np.divide(np.abs(left @ sensitivity), own, out=np.zeros_like(own), where=new)
        best = int(gain.argmax())
        after = float(np.sqrt(max(rest**2 - gain[best] ** 2, 0.0)))
        if after > (1 - WORTH) * rest:
            break
        axis = sensitivity[:, best] / own[best]
        left = left - axis * (axis @ left)
        sensitivity = sensitivity - np.outer(axis, axis @ sensitivity)
        chosen.append(best)
        remaining.append(after / whole)
        rest = after
    picked = problem.sensitivity[:, chosen]
    step = balanced_step(picked, problem.difference, np.ones(len(left)), jump=jump)
    change, weight = np.zeros(len(sizes)), np.zeros(len(sizes))
    change[chosen] = step.parameters
    weight[chosen] = np.linalg.norm(picked * step.parameters, axis=0) / (whole or 1.0)
    return LinearLocation(
        change, weight, np.abs(change) > threshold, np.array(remaining), step.rank, step.condition_number
    )
