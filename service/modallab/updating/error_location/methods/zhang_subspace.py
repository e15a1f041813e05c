"""Zhang's subspace method: forward selection of coefficients by orthogonal least squares."""

import numpy as np

from modallab.updating.error_location.method import (
    LOCATORS,
    ErrorLocationMethod,
    LinearLocation,
    LinearProblem,
)
from modallab.updating.error_location.settings import ERROR_LOCATION
from modallab.updating.solve import balanced_step


def zhang_subspace(problem: LinearProblem, *, threshold: float, jump: float) -> LinearLocation:
    """Select coefficients by forward selection: each one added leaves the least residual.

    min |delta - S^k dp^k| [2.31] over k = 1, 2, ...: each time the coefficient joins that leaves least with
    all chosen before solved for again, until the next would take away less than a twentieth. Those that end
    within the threshold of 1 are let go again. Zhang's second method, as the 1992 thesis, section 2.3.3,
    gives it; the search is orthogonal least squares: Chen, S., Billings, S. A. and Luo, W. (1989),
    International Journal of Control 50(5), 1873-1896.
    """
    sensitivity, residual = problem.sensitivity.copy(), problem.difference.copy()
    sizes = np.linalg.norm(sensitivity, axis=0)
    total_norm = float(np.linalg.norm(residual))
    subset: list[int] = []
    remaining: list[float] = []
    residual_norm = total_norm
    while residual_norm > ERROR_LOCATION.rounding_difference * np.sqrt(len(residual)) and len(subset) < min(
        sensitivity.shape
    ):
        column_norms = np.linalg.norm(sensitivity, axis=0)
        is_candidate = (column_norms > ERROR_LOCATION.min_independent_share * sizes) & ~np.isin(
            np.arange(len(column_norms)), subset
        )
        gain = np.divide(
            np.abs(residual @ sensitivity), column_norms, out=np.zeros_like(column_norms), where=is_candidate
        )
        best = int(gain.argmax())
        next_norm = float(np.sqrt(max(residual_norm**2 - gain[best] ** 2, 0.0)))
        if next_norm > (1 - ERROR_LOCATION.min_reduction) * residual_norm:
            break
        axis = sensitivity[:, best] / column_norms[best]
        residual = residual - axis * (axis @ residual)
        sensitivity = sensitivity - np.outer(axis, axis @ sensitivity)
        subset.append(best)
        remaining.append(next_norm / total_norm)
        residual_norm = next_norm
    subset_sensitivity = problem.sensitivity[:, subset]
    step = balanced_step(subset_sensitivity, problem.difference, np.ones(len(residual)), jump=jump)
    change, weight = np.zeros(len(sizes)), np.zeros(len(sizes))
    change[subset] = step.parameters
    weight[subset] = np.linalg.norm(subset_sensitivity * step.parameters, axis=0) / (total_norm or 1.0)
    return LinearLocation(
        change, weight, np.abs(change) > threshold, np.array(remaining), step.rank, step.condition_number
    )


LOCATORS.register("zhang_subspace")(ErrorLocationMethod(zhang_subspace))
