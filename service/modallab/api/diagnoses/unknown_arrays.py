"""Curve of an unknown effect as arrays."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.api.arrays import ArraySpec
from modallab.core.arrays import FloatArray
from modallab.diagnosis.result import Unknown
from modallab.diagnosis.unknown.adoption import model_values

UNKNOWN_ARRAYS = {
    "unknown.freq": ArraySpec("Hz, frequencies of the curve of an unknown effect", "n_points", optional=True),
    "unknown.value": ArraySpec(
        "N/m, N m/rad or 1, its dynamic stiffness or gain", "n_points", "complex", optional=True
    ),
    "unknown.error": ArraySpec(
        "unit of the value, standard error of its real and of its imaginary part", "n_points", optional=True
    ),
    "unknown.model": ArraySpec(
        "unit of the value, that of its curve model at `freq`, where it has one of its own motion",
        *("n_freq", "complex"),
        optional=True,
    ),
}


def unknown_arrays(unknown: Unknown, freq: FloatArray) -> dict[str, NDArray[Any]]:
    """Return the curve of an unknown effect by the names of `UNKNOWN_ARRAYS`.

    Parameters
    ----------
    freq
        (n_freq,) Hz, lines of the measurement.
    """
    arrays: dict[str, NDArray[Any]] = {
        "unknown.freq": np.array([point.frequency for point in unknown.curve]),
        "unknown.value": np.array([complex(point.real, point.imaginary) for point in unknown.curve]),
        "unknown.error": np.array([point.standard_error for point in unknown.curve]),
    }
    model = model_values(unknown, freq[freq > 0])
    if model is None:
        return arrays
    values = np.full(len(freq), complex(np.nan, np.nan))  # a law may have no value at 0 Hz
    values[freq > 0] = model
    return arrays | {"unknown.model": values}
