"""Check that model and log book can predict a measurement."""

import numpy as np

from modallab.core.errors import InvalidInputError
from modallab.diagnosis.predicting.settings import PREDICTION
from modallab.fe.structure import Structure
from modallab.rig.measurement import Measurement


def check_comparable(structure: Structure, measurement: Measurement) -> None:
    """Raise unless the model and the log book can predict the measurement.

    Raises
    ------
    InvalidInputError
        If the frequency axis is not the log book's, 0 Hz apart, or several forces act at once.
    UnknownDofError
        If the model lacks a measured DoF.
    """
    for dof in (measurement.setup.drive, *measurement.frf.outputs):
        structure.index(dof)
    if measurement.frf.values.shape[2] != 1:
        raise InvalidInputError("one force at a time", field="inputs", allowed=1)
    axis, freq = measurement.setup.analyser.freq, measurement.frf.freq
    if freq[0] > 0:
        axis = axis[1:]
    tolerance = PREDICTION.frequency_tolerance
    if len(axis) != len(freq) or not np.allclose(axis, freq, rtol=tolerance, atol=tolerance * axis[-1]):
        raise InvalidInputError(
            "the frequency axis is not the one that the log book declares",
            field="freq",
            value=f"{len(freq)} lines to {freq[-1]:g} Hz",
            allowed=f"{len(axis)} lines to {axis[-1]:g} Hz",
        )
