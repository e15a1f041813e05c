"""Replies of modal models."""

from typing import Any

from modallab.api.replies import reply, reply_of, stored_reply
from modallab.core.frequency_inconsistency import FrequencyInconsistency
from modallab.core.modal_model import ModalModel, Mode
from modallab.correlation.complexity import ShapeComplexity, shape_complexities
from modallab.store.base import Entry

ModeReply: Any = reply(
    Mode, "Mode", complexity=(reply_of(ShapeComplexity), "Phase differences between the points of the mode.")
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
        "as mobility.",
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
    model: ModalModel, entry: Entry, reply: type[Any] = ModalModelReply, **more: Any
) -> Any:
    """Return the reply of a stored modal model."""
    complexities = shape_complexities(model.shapes) if model.modes else ()
    errors = model.resynthesis_error
    return reply.of(
        model,
        entry,
        modes=[
            vars(mode) | {"complexity": complexity}
            for mode, complexity in zip(model.modes, complexities, strict=True)
        ],
        resynthesis_error=None if errors is None else dict(zip(model.frfs, errors.tolist(), strict=True)),
        drive=None if model.drive is None else str(model.drive),
        frfs=list(model.frfs) if model.references else [],
        measurement_id=entry.inputs.get("measurement_id"),
        **more,
    )
