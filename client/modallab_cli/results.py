"""Results of the numerics in this process as those of the client, which print and draw themselves."""

from datetime import UTC, datetime

import modallab
from modallab.api.diagnoses.replies import diagnosis_reply
from modallab.api.from_files import DiagnosisOutcome
from modallab.api.measurements.replies import measurement_reply
from modallab.rig.measurement import Measurement as Measured
from modallab.store.base import Entry
from modallab.store.codec import CODECS, arrays_of
from modallab_client import Diagnosis, Measurement
from modallab_client._plausibility import warned
from modallab_client._read import read_as
from modallab_client.methods.diagnoses import diagnosis_curves
from modallab_client.methods.measurements import measurement_of


def measurement_result(measurement: Measured) -> Measurement:
    """Return measured FRFs as the client has them, after warnings of what is surely a slip."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    entry = Entry("", "measurements", "", now, modallab.__version__, {"rig_id": ""}, measurement.seed)
    reply = measurement_reply(measurement, entry).model_dump(mode="json")
    return warned(measurement_of(reply, arrays_of(measurement)))


def diagnosis_result(outcome: DiagnosisOutcome) -> Diagnosis:
    """Return a diagnosis as the client has it, with its curves."""
    reply = diagnosis_reply(outcome.diagnosis, outcome.entry).model_dump(mode="json")
    _, arrays = CODECS["diagnosis"].take_apart(outcome.diagnosis)
    return read_as(Diagnosis, reply, curves=diagnosis_curves(arrays))
