"""What prior and data together say of coefficients: how sure each is, and which are wrong."""

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.updating.location import NOTICEABLE, NOTICEABLE_LOSS
from modallab.updating.log_coefficients import changes, slopes
from modallab.updating.parameterisation import Parameterisation, by_member
from modallab.updating.sparse_bayes import Posterior

CLEAR = 3.0  # standard errors from no change at which a coefficient is suspected


def standard_errors(
    parameterisation: Parameterisation, values: FloatArray, belief: Posterior
) -> dict[str, dict[int, float]]:
    """Return those of the coefficients (n_params,) that the prior left free to move, by part and member."""
    kept = np.flatnonzero(belief.kept)
    if not kept.size:
        return {}
    errors = belief.errors * slopes(parameterisation, values)
    free = Parameterisation(
        tuple(parameterisation.macros[i] for i in kept), parameterisation.lower, parameterisation.upper
    )
    return by_member(free, errors[kept], parts=parameterisation.parts)


def suspected(
    parameterisation: Parameterisation, values: FloatArray, belief: Posterior
) -> dict[str, tuple[int, ...]]:
    """Return members by part whose coefficients (n_params,) moved noticeably, and by more than chance."""
    away = np.abs(values - parameterisation.unchanged)
    noticeable: BoolArray = away > np.where(parameterisation.damping, NOTICEABLE_LOSS, NOTICEABLE)
    far = np.abs(changes(parameterisation, values))
    clear = noticeable & (far > CLEAR * belief.errors)
    wrong = [macro for macro, one in zip(parameterisation.macros, clear, strict=True) if one]
    return {
        part.value: tuple(sorted(n for macro in wrong if macro.part is part for n in macro.members))
        for part in parameterisation.parts
    }
