"""Replies of modal models."""

from collections.abc import Collection
from typing import Annotated, Any, Literal

from fastapi import Query

from modallab.api.replies import reply, reply_of, stored_reply
from modallab.core.frequency_inconsistency import FrequencyInconsistency
from modallab.core.modal_model import ModalModel, Mode
from modallab.correlation.complexity import ShapeComplexity, shape_complexities
from modallab.extraction.summary import flag_counts, main_flags, summarised_flags, summarised_notes
from modallab.store.base import Entry

Detail = Literal["flags", "notes"]
DETAILS = Annotated[
    list[Detail],
    Query(
        description="`flags`: every flag of every mode; `notes`: every note; repeated for both. By default "
        "flags of many FRFs, and notes that differ in numbers only, are counted.",
        max_length=2,
        default_factory=list,
    ),
]
ModeReply: Any = reply(
    Mode,
    "Mode",
    complexity=(reply_of(ShapeComplexity), "Phase differences between the points of the mode."),
    flags=(
        list[str],
        "Warnings about this mode, those that matter most first; of many FRFs the number, and with "
        "`?details=flags` each one.",
    ),
    flag_counts=(dict[str, int], "Number of flags on this mode by kind, those that matter most first."),
)
InconsistencyReply: Any = reply(
    FrequencyInconsistency,
    "FrequencyInconsistency",
    unit=(str, "Unit of the size: kg of a roving mass, else 1."),
)
_ADDED: dict[str, tuple[Any, str]] = {
    "modes": (list[ModeReply], "Modes in rising natural frequency; `/arrays` has their shapes."),
    "frequency_inconsistency": (
        InconsistencyReply | None,
        "Frequency differences between the FRFs; null where they agree. `/arrays` has those of each FRF.",
    ),
    "resynthesis_error": (
        dict[str, float] | None,
        "By FRF: rms of the difference to the FRF that modes and residuals make, over the rms of the FRF, "
        "as mobility, over the lines of `ranges`.",
    ),
    "flag_counts": (dict[str, int], "Number of flags on all modes by kind, those that matter most first."),
    "main_flags": (list[str], "The flags that matter most, at most three, with the number of the mode."),
    "notes": (
        list[str],
        "Remarks on the extraction, in sentences; of more than three that differ in numbers only the first, "
        "and with `?details=notes` all.",
    ),
    "drive": (str | None, "DoF common to all FRFs; null where there is none, or several."),
    "frfs": (
        list[str],
        "Names of the FRFs in the order of the arrays: a DoF, of several references `5:+Y / 1:+Y`.",
    ),
    "measurement_id": (str | None, "Measurement from which the modes were extracted."),
}
_CHART = ("chart",)  # has a route of its own
ModalModelReply = stored_reply(ModalModel, "ModalModel", leave_out=_CHART, **_ADDED)
ExpandedReply = stored_reply(
    ModalModel,
    "ExpandedModalModel",
    leave_out=_CHART,
    **_ADDED,
    fit_residuals=(list[float], "By mode: norm of measured minus expanded shape over the measured norm."),
    rayleigh_frequencies=(list[float], "Hz, by mode: from the Rayleigh quotient of the expanded shape."),
)


def modal_model_reply(
    model: ModalModel,
    entry: Entry,
    reply: type[Any] = ModalModelReply,
    *,
    details: Collection[Detail] = (),
    **more: Any,
) -> Any:
    """Return the reply of a stored modal model.

    Parameters
    ----------
    details
        What is listed in full, not summarised.
    """
    complexities = shape_complexities(model.shapes) if model.modes else ()
    errors = model.resynthesis_error
    return reply.of(
        model,
        entry,
        modes=[
            vars(mode)
            | {
                "complexity": complexity,
                "flags": flags_of(mode, details),
                "flag_counts": flag_counts(mode.flags),
            }
            for mode, complexity in zip(model.modes, complexities, strict=True)
        ],
        flag_counts=flag_counts(flag for mode in model.modes for flag in mode.flags),
        main_flags=main_flags(model.modes),
        notes=list(model.notes) if "notes" in details else summarised_notes(model.notes),
        resynthesis_error=None if errors is None else dict(zip(model.frfs, errors.tolist(), strict=True)),
        drive=None if model.drive is None else str(model.drive),
        frfs=list(model.frfs) if model.references else [],
        measurement_id=entry.inputs.get("measurement_id"),
        **more,
    )


def flags_of(mode: Mode, details: Collection[Detail]) -> list[str]:
    """Return the flags of a mode, all of them or summarised."""
    return list(mode.flags) if "flags" in details else summarised_flags(mode.flags)
