"""How natural frequencies differ between FRFs that were not measured on the same structure."""

from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import FloatArray, IntArray


class InconsistencyCause(StrEnum):
    """What makes frequencies differ from FRF to FRF."""

    ROVING_MASS = "roving_mass"  # they fall by half the mass times the squared shape where it sits
    SQUARED_SHAPE = "squared_shape"  # as above, but shapes without scale do not tell the mass
    STEADY_DRIFT = "steady_drift"  # all alike, and in proportion to the number of the FRF
    UNKNOWN = "unknown"


@dataclass(frozen=True, eq=False)
class FrequencyInconsistency:
    """Frequencies that differ between FRFs by more than their random error; NaN where a fit did not count.

    What `size` is depends on the cause. `roving_mass`: the kg that move with the response.
    `steady_drift`: the relative change of frequency from the first FRF to the last. Else 0.
    """

    cause: InconsistencyCause
    shift: FloatArray  # (n_modes, n_frf) Hz, of each fit from the plain mean of its mode
    shift_error: FloatArray  # (n_modes, n_frf) Hz, standard error of that fit
    chi_square: FloatArray  # (n_modes,) of the fits about their weighted mean
    degrees: IntArray  # (n_modes,) of freedom: one less than the fits that count
    explained: float  # 0 to 1, the part of all chi-square that goes with the cause
    size: float
    size_error: float  # standard error, what the first-order law neglects included
    mode_size: FloatArray  # (n_modes,) the same from each mode alone
    mode_size_error: FloatArray  # (n_modes,)
    still_frequency: FloatArray  # (n_modes,) Hz, without roving mass, or before the drift; else the mean

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, field.name, _read_only(value))


def _read_only(values: NDArray[Any]) -> NDArray[Any]:
    array = np.array(values)  # `frozen` would refuse NaN, which says here that a fit did not count
    array.flags.writeable = False
    return array
