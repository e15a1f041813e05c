"""Macro elements suspected after the location stage."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, frozen
from modallab.updating.parameterisation import MacroElement, Parameterisation
from modallab.updating.settings import LOCATION


@dataclass(frozen=True, eq=False)
class Suspicion:
    """Suspected members, and their initial coefficients in the updating stage."""

    parameterisation: Parameterisation
    """One coefficient for each part of each suspected member, or of a group that is whole."""
    start: FloatArray
    """(n_params,) coefficient of the macro element of each."""

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
    macro elements return to nominal for stage two. A group that is the only one has nothing to locate: its
    members keep one coefficient a part. 1992 thesis, sections 3.3 and 6.3.

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
            refined_macros = _refined(macro, parameterisation)
            macros += refined_macros
            start += [float(value)] * len(refined_macros)
    if not macros:
        return None
    refined = Parameterisation(tuple(macros), parameterisation.lower, parameterisation.upper)
    return Suspicion(refined, np.array(start))


def _refined(macro: MacroElement, parameterisation: Parameterisation) -> list[MacroElement]:
    """Return the macro elements of a suspected one in stage two: its members, or itself if it is alone."""
    is_nodal = macro.part.is_nodal
    places = {other.members for other in parameterisation.macros if other.part.is_nodal == is_nodal}
    if len(places) == 1:
        return [macro]
    return [MacroElement((number,), macro.part) for number in macro.members]


def _effective_threshold(change: FloatArray, threshold: float, noticeable: float) -> float:
    largest = float(change.max(initial=0.0))
    return threshold if largest > threshold else max(largest / 2, noticeable)
