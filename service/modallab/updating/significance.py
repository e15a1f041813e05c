"""Standard errors of coefficients, and those that differ significantly from their nominal value."""

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.updating.log_coefficients import log_changes, log_derivatives
from modallab.updating.parameterisation import Parameterisation, by_member
from modallab.updating.settings import LOCATION, SIGNIFICANCE
from modallab.updating.sparse_bayes import Posterior


def standard_errors(
    parameterisation: Parameterisation, values: FloatArray, posterior: Posterior
) -> dict[str, dict[int, float]]:
    """Return standard errors of the active coefficients (n_params,), by part and member."""
    active = np.flatnonzero(posterior.is_active)
    if not active.size:
        return {}
    errors = posterior.errors * log_derivatives(parameterisation, values)
    free = Parameterisation(
        tuple(parameterisation.macros[i] for i in active), parameterisation.lower, parameterisation.upper
    )
    return by_member(free, errors[active], parts=parameterisation.parts)


def suspected(
    parameterisation: Parameterisation, values: FloatArray, posterior: Posterior
) -> dict[str, tuple[int, ...]]:
    """Return suspected members by part: coefficients (n_params,) noticeably and significantly off nominal."""
    distance = np.abs(values - parameterisation.nominal)
    is_noticeable: BoolArray = distance > np.where(
        parameterisation.damping, LOCATION.noticeable_loss_factor, LOCATION.noticeable_change
    )
    log_change = np.abs(log_changes(parameterisation, values))
    is_significant = is_noticeable & (log_change > SIGNIFICANCE.min_deviations * posterior.errors)
    suspects = [
        macro
        for macro, significant in zip(parameterisation.macros, is_significant, strict=True)
        if significant
    ]
    return {
        part.value: tuple(sorted(n for macro in suspects if macro.part is part for n in macro.members))
        for part in parameterisation.parts
    }
