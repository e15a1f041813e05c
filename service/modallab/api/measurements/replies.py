"""Replies of measurements: metadata, lab log and truth."""

from typing import Any

from modallab.api.replies import replies_of, reply_of, stored_reply
from modallab.api.rigs.replies import SetupReply, rig_request, setup_reply
from modallab.core.frf import FrfKind
from modallab.core.physics_warning import PhysicsWarning
from modallab.rig.measurement import Measurement
from modallab.rig.plausibility import measurement_warnings
from modallab.store.base import Entry, Truth

_PARTS = ("frf", "setup", "seed", "records", "estimates")
_RIG_ID: tuple[Any, str] = (str, "Rig of the test.")
MeasurementReply = stored_reply(
    Measurement,
    "Measurement",
    leave_out=_PARTS,
    rig_id=_RIG_ID,
    rig=(SetupReply, "Rig as declared."),
    kind=(FrfKind, "Kind of the FRFs: receptance, mobility or inertance."),
    outputs=(list[str], "Response DoFs."),
    inputs=(list[str], "Force DoFs."),
    n_lines=(int, "Number of frequency lines."),
    frequency_min=(float, "Hz, frequency of the first line."),
    frequency_max=(float, "Hz, frequency of the last line."),
    n_records=(int, "Number of time records of every run that were kept."),
    n_estimates=(int, "Number of estimates that were kept while averages were taken, the last after all."),
    warnings=(replies_of(PhysicsWarning), "What is surely a slip of a unit or a setting."),
)
LogReply = stored_reply(
    Measurement,
    "MeasurementLog",
    leave_out=_PARTS,
    rig_id=_RIG_ID,
    rig=(dict[str, Any], "Body of `POST /v1/rigs` that declares the same rig."),
)
TruthReply: Any = reply_of(Truth)


def measurement_reply(measurement: Measurement, entry: Entry) -> Any:
    """Return the reply of a stored measurement."""
    frf = measurement.frf
    return MeasurementReply.of(
        measurement,
        entry,
        rig_id=entry.inputs["rig_id"],
        rig=setup_reply(measurement.setup),
        kind=frf.kind,
        outputs=[str(dof) for dof in frf.outputs],
        inputs=[str(dof) for dof in frf.inputs],
        n_lines=len(frf.freq),
        frequency_min=float(frf.freq[0]),
        frequency_max=float(frf.freq[-1]),
        n_records=0 if measurement.records is None else len(measurement.records),
        n_estimates=0 if measurement.estimates is None else len(measurement.estimates) + 1,
        warnings=measurement_warnings(measurement),
    )


def log_reply(measurement: Measurement, entry: Entry) -> Any:
    """Return the lab log of a measurement: declaration and request, which make it again with the truth.

    To the byte it is reproduced by the same `version` and `libraries`.
    """
    return LogReply.of(measurement, entry, rig_id=entry.inputs["rig_id"], rig=rig_request(measurement.setup))
