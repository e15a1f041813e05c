"""Stage one: which macro elements a measurement contradicts."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, frozen
from modallab.updating.parameterisation import MacroElement, Parameterisation


@dataclass(frozen=True, eq=False)
class Suspicion:
    """The members that stage one suspects, and where stage two starts with them."""

    parameterisation: Parameterisation  # one coefficient for every part of every suspected member
    start: FloatArray  # (n_params,) the coefficient of the macro element each one came from

    def __post_init__(self) -> None:
        shape = (len(self.parameterisation.macros),)
        object.__setattr__(self, "start", frozen(self.start, float, shape, name="start"))


def suspicion(parameterisation: Parameterisation, values: FloatArray, threshold: float) -> Suspicion | None:
    """Return the members of every macro element whose coefficient moved beyond the threshold, if any.

    Coefficients of the others go back to 1 for stage two. 1992 thesis, section 3.3.

    Parameters
    ----------
    values
        (n_macros,) where stage one ended.
    """
    macros: list[MacroElement] = []
    start: list[float] = []
    for macro, value in zip(parameterisation.macros, values, strict=True):
        if abs(value - 1.0) > threshold:
            macros += [MacroElement((number,), macro.part) for number in macro.members]
            start += [float(value)] * len(macro.members)
    if not macros:
        return None
    inside = Parameterisation(tuple(macros), parameterisation.lower, parameterisation.upper)
    return Suspicion(inside, np.array(start))
