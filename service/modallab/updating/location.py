"""Macro elements suspected after the location stage."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, frozen
from modallab.updating.parameterisation import MacroElement, Parameterisation
from modallab.updating.settings import LOCATION


@dataclass(frozen=True, eq=False)
class Suspicion:
    """Suspected members, and their initial coefficients in the updating stage."""

    parameterisation: Parameterisation  # one coefficient for each part of each suspected member
    start: FloatArray  # (n_params,) coefficient of the macro element of each member

    def __post_init__(self) -> None:
        shape = (len(self.parameterisation.macros),)
        object.__setattr__(self, "start", frozen(self.start, float, shape, name="start"))


def suspect_members(
    parameterisation: Parameterisation,
    values: FloatArray,
    threshold: float,
    damping_threshold: float = LOCATION.damping_threshold,
) -> Suspicion | None:
    """Return the members of macro elements whose coefficient changed beyond the threshold, None if none did.

    One wrong member changes the coefficient of a macro element of many by little. Where none exceeds the
    threshold, those with at least half the largest change are suspected, if that one is noticeable. Loss
    factors have a threshold of their own and are compared with one another only. Coefficients of the other
    macro elements return to nominal for stage two. 1992 thesis, sections 3.3 and 6.3.

    Parameters
    ----------
    values
        (n_macros,) coefficients at the end of stage one.
    """
    change = np.abs(values - parameterisation.nominal)
    damping = parameterisation.damping
    thresholds = np.where(
        damping,
        _effective_threshold(change[damping], damping_threshold, LOCATION.noticeable_loss_factor),
        _effective_threshold(change[~damping], threshold, LOCATION.noticeable_change),
    )
    macros: list[MacroElement] = []
    start: list[float] = []
    for macro, value, is_suspect in zip(parameterisation.macros, values, change > thresholds, strict=True):
        if is_suspect:
            macros += [MacroElement((number,), macro.part) for number in macro.members]
            start += [float(value)] * len(macro.members)
    if not macros:
        return None
    refined = Parameterisation(tuple(macros), parameterisation.lower, parameterisation.upper)
    return Suspicion(refined, np.array(start))


def _effective_threshold(change: FloatArray, threshold: float, noticeable: float) -> float:
    largest = float(change.max(initial=0.0))
    return threshold if largest > threshold else max(largest / 2, noticeable)
