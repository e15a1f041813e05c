"""Replies of diagnoses."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from modallab.api.replies import replies_of, stored_reply
from modallab.api.wire import Reply
from modallab.diagnosis.reporting.verdict_text import headline
from modallab.diagnosis.result import Diagnosis
from modallab.store.base import Entry


@dataclass(frozen=True)
class FollowUpTest:
    """Further test of the same structure that the diagnosis explained together with the first."""

    measurement_id: str
    """Measurement of the further test."""
    changed: Mapping[str, object]
    """Changes against the first test."""


class Adoption(Reply):
    """Model and log book with the unknown effect of a diagnosis in them."""

    structure_id: str
    """Model: with the added effects where the unknown effect acts beside them."""
    rig_id: str
    """Log book, likewise."""
    kind: str
    """Kind of the effect that was added: `tabulated_stiffness` or `tabulated_response`."""


DiagnosisReply = stored_reply(
    Diagnosis,
    "Diagnosis",
    leave_out=("structure", "setup", "curves", "seed"),
    follow_ups=(replies_of(FollowUpTest), "Further tests that were explained together with the first."),
    headline=(str, "Verdict in one sentence, as the report has it."),
    structure_id=(str, "Model with the added effects."),
    rig_id=(str, "Log book with the added effects."),
)


def diagnosis_reply(diagnosis: Diagnosis, entry: Entry) -> Any:
    """Return the reply of a stored diagnosis."""
    return DiagnosisReply.of(
        diagnosis,
        entry,
        follow_ups=[
            FollowUpTest(entry.inputs[f"follow_up_{i}"], changes)
            for i, changes in enumerate(diagnosis.follow_ups, 1)
        ],
        headline=headline(diagnosis),
        structure_id=entry.inputs["extended_structure_id"],
        rig_id=entry.inputs["extended_rig_id"],
    )
