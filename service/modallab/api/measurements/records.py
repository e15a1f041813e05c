"""Time records of a measurement as arrays and as a sound file."""

import io
from typing import Annotated, Any, Literal

import numpy as np
from fastapi import Query
from numpy.typing import NDArray

from modallab.api import array_tables
from modallab.api.files import WAV_TYPE
from modallab.core.errors import InvalidInputError, NotFoundError
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.rig.time_records import FORCE_UNIT, RESPONSE_UNIT, TimeRecords

RecordFormat = Annotated[
    Literal["npz", "wav"],
    Query(alias="format", description="`npz` has all in double precision, `wav` in single precision"),
]
_ARRAYS = array_tables.RECORDS[200]
RECORD_REPLIES: dict[int | str, dict[str, Any]] = {
    200: {
        "description": f"{_ARRAYS['description']}; or a wav file",
        "content": _ARRAYS["content"] | {WAV_TYPE: {"schema": {"type": "string", "format": "binary"}}},
    }
}


def records_of(measurement: Measurement) -> TimeRecords:
    """Return the time records of a measurement.

    Raises
    ------
    NotFoundError
        If none were kept.
    """
    if measurement.records is None:
        raise NotFoundError("this measurement kept no time records: state `records` when it is started")
    return measurement.records


def record_arrays(records: TimeRecords, setup: RigSetup) -> dict[str, NDArray[Any]]:
    """Return time records as arrays with the DoFs of their channels."""
    runs = setup.acquisition_runs
    return {
        "force": records.force,
        "response": records.response,
        "sample_rate": np.array(records.sample_rate),
        "inputs": np.array([[str(dof) for dof in run.drives] for run in runs]),
        "outputs": np.array([[str(dof) for dof in run.outputs] for run in runs]),
        "force_unit": np.array(FORCE_UNIT),
        "response_unit": np.array(RESPONSE_UNIT),
    }


def wav_file(records: TimeRecords) -> bytes:
    """Return time records as a wav file in 32-bit floating point, in N and m/s^2.

    Raises
    ------
    InvalidInputError
        If the sample rate is no whole number of Hz, as that of a wav file is.
    """
    from scipy.io import wavfile  # only such a request needs it

    rate = round(records.sample_rate)
    if not np.isclose(rate, records.sample_rate, rtol=1e-9, atol=0):
        raise InvalidInputError(
            f"a wav file needs a sample rate of whole Hz, not {records.sample_rate:g} Hz",
            field="format",
            value="wav",
            allowed="npz",
        )
    channels = np.concatenate([records.force, records.response], axis=-1)
    buffer = io.BytesIO()
    wavfile.write(
        buffer, rate, channels.reshape(channels.shape[0] * channels.shape[1], -1).astype(np.float32)
    )
    return buffer.getvalue()
