"""Stage one: which macro elements a measurement contradicts."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, frozen
from modallab.updating.parameterisation import MacroElement, Parameterisation
from modallab.updating.settings import LOCATION


@dataclass(frozen=True, eq=False)
class Suspicion:
    """The members that stage one suspects, and where stage two starts with them."""

    parameterisation: Parameterisation  # one coefficient for every part of every suspected member
    start: FloatArray  # (n_params,) the coefficient of the macro element each one came from

    def __post_init__(self) -> None:
        shape = (len(self.parameterisation.macros),)
        object.__setattr__(self, "start", frozen(self.start, float, shape, name="start"))


def suspect_members(
    parameterisation: Parameterisation,
    values: FloatArray,
    threshold: float,
    damping_threshold: float = LOCATION.damping_threshold,
) -> Suspicion | None:
    """Return the members of every macro element whose coefficient moved beyond the threshold, if any.

    One wrong element moves a macro element of many by little. Where none moves beyond the threshold,
    those that moved at least half as far as the farthest are taken, if that one moved noticeably.
    Loss factors have a threshold of their own and are judged among themselves. Coefficients of the
    others go back to no change for stage two. 1992 thesis, sections 3.3 and 6.3.

    Parameters
    ----------
    values
        (n_macros,) where stage one ended.
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
