"""Frequency inconsistency: natural frequencies that differ between FRFs of one test."""

from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import FloatArray
from modallab.core.reply import IntVector, NanFloat, Vector


class InconsistencyCause(StrEnum):
    """Cause of frequency differences between FRFs."""

    ROVING_MASS = "roving_mass"  # relative shift: -mass shape^2 / 2 at the mass's DoF
    SQUARED_SHAPE = "squared_shape"  # as above, with unscaled shapes: the mass is unknown
    STEADY_DRIFT = "steady_drift"  # same relative shift of all modes, linear in the FRF's index
    UNKNOWN = "unknown"


@dataclass(frozen=True, eq=False)
class FrequencyInconsistency:
    """Natural frequencies that differ between FRFs by more than their random error.

    NaN marks a fit that was not valid. The meaning of `size` depends on the cause: `roving_mass`, kg that
    move with the response; `steady_drift`, relative frequency change from the first FRF to the last.
    """

    cause: InconsistencyCause
    """Cause identified from the pattern of the shifts."""
    shift: FloatArray
    """Hz, (n_modes, n_frf) deviation of each fit from the unweighted mean of its mode."""
    shift_error: FloatArray
    """Hz, (n_modes, n_frf) standard error of each fit."""
    chi_square: Vector
    """(n_modes,) chi-square of the fits about their weighted mean."""
    degrees: IntVector
    """(n_modes,) degrees of freedom: the number of valid fits less one."""
    explained: NanFloat
    """Fraction of the total chi-square explained by the cause, 0 to 1."""
    size: NanFloat
    """Size of the cause: kg of a roving mass, relative frequency change of a steady drift, else 0."""
    size_error: NanFloat
    """Standard error of the size, with the second-order terms that the model neglects."""
    mode_size: Vector
    """(n_modes,) size estimated from each mode alone."""
    mode_size_error: Vector
    """(n_modes,) standard errors of these sizes."""
    still_frequency: Vector
    """Hz, (n_modes,) frequency without the roving mass, or before the drift; else the mean."""

    @property
    def unit(self) -> str:
        """Unit of the size: kg of a roving mass, else 1."""
        return "kg" if self.cause is InconsistencyCause.ROVING_MASS else "1"

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, field.name, _read_only(value))


def _read_only(values: NDArray[Any]) -> NDArray[Any]:
    array = np.array(values)  # `frozen` rejects NaN, which marks an invalid fit here
    array.flags.writeable = False
    return array
