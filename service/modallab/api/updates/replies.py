"""Replies of updates: one model for each family of methods."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Union

from pydantic import Field

from modallab.api.replies import replies_of, reply, stored_reply, wire_type
from modallab.core.reply import Vector
from modallab.store.base import Entry
from modallab.updating.direct.result import DirectResult, DofError
from modallab.updating.error_location.method import LocationResult
from modallab.updating.iteration import Iteration
from modallab.updating.method import UpdateResult
from modallab.updating.posterior import PosteriorSample, SampledCoefficient
from modallab.updating.responses.result import ResponseFit

IterationReply: Any = reply(Iteration, "Iteration", max_change=(float, "Largest change of a coefficient."))
PosteriorReply: Any = reply(
    PosteriorSample,
    "PosteriorSample",
    leave_out=("macros",),  # each coefficient names its own
    n_draws=(int, "Number of draws."),
    coefficients=(replies_of(SampledCoefficient), "Marginal distribution of each free coefficient."),
)
ResponseFitReply: Any = reply(
    ResponseFit,
    "ResponseFit",
    n_lines=(int, "Number of fitted lines."),
    band=(tuple[float, float], "Hz, lowest and highest fitted line."),
)
_BY_STAGE = wire_type(Mapping[str, Vector])
_STOPPED = (str, "Reason for the end, for readers.")
_COEFFICIENTS: dict[str, tuple[Any, str]] = {
    "iterations": (dict[str, int], "Number of steps by stage, `location` and `updating`."),
    "history": (list[IterationReply], "Every step of both stages."),
    "posterior": (PosteriorReply | None, "Draws from the posterior; null where none were asked for."),
    "structure_id": (str, "Updated model."),
}
IterativeReply = stored_reply(
    UpdateResult,
    "IterativeUpdate",
    leave_out=("structure", "responses"),
    kind=(Literal["iterative"], "Update on modes: coefficients are corrected by iteration."),
    frequencies=(_BY_STAGE, "Hz, natural frequencies (n_modes,): `measured`, `before`, `location`, `after`."),
    mac=(_BY_STAGE, "MAC of paired modes (n_modes,): `before`, `location`, `after`."),
    **_COEFFICIENTS,
)
ResponseBasedReply = stored_reply(
    UpdateResult,
    "ResponseBasedUpdate",
    leave_out=("structure", "mac"),
    kind=(Literal["response_based"], "Update on FRFs: coefficients are corrected by iteration."),
    frequencies=(_BY_STAGE, "Hz, natural frequencies of the model: `before`, `location`, `after`."),
    responses=(ResponseFitReply, "Agreement with the measured FRFs."),
    **_COEFFICIENTS,
)
DirectReply = stored_reply(
    DirectResult,
    "DirectUpdate",
    leave_out=("modes",),  # told as `n_modes`, `frequencies` and `mac`
    kind=(Literal["direct"], "Direct method: matrices are corrected, or their errors located, in one step."),
    converged=(bool, "True if there is an updated model with the measured modes."),
    stopped_because=_STOPPED,
    n_modes=(int, "Number of measured modes that the method used, the first of `frequencies`."),
    frequencies=(
        _BY_STAGE,
        "Hz, natural frequencies: `measured`, `before` and, of a correction, `after`.",
    ),
    mac=(_BY_STAGE, "MAC with the nearest modes: `before` and, of a correction, `after`."),
    dof_errors=(
        wire_type(Mapping[str, tuple[DofError, ...]]),
        "By matrix: errors of all DoFs, the largest first.",
    ),
)
ErrorLocationReply = stored_reply(
    LocationResult,
    "ErrorLocation",
    kind=(Literal["error_location"], "Error location in one linear step: the model stays as it is."),
    stopped_because=_STOPPED,
    frequencies=(_BY_STAGE, "Hz, natural frequencies of the paired modes (n_modes,): `measured`, `before`."),
    mac=(_BY_STAGE, "MAC of the paired modes (n_modes,): `before`."),
)
_REPLIES = (IterativeReply, ResponseBasedReply, DirectReply, ErrorLocationReply)
UpdateReply: Any = Annotated[Union[_REPLIES], Field(discriminator="kind")]  # noqa: UP007


def update_reply(result: UpdateResult | DirectResult | LocationResult, entry: Entry) -> Any:
    """Return the reply of a stored update, by the family of its method."""
    match result:
        case DirectResult():
            return _direct_reply(result, entry)
        case LocationResult():
            return _location_reply(result, entry)
    fields = {
        "frequencies": result.frequencies.by_name,
        "structure_id": entry.inputs["updated_structure_id"],
    }
    if result.responses is not None:
        return ResponseBasedReply.of(result, entry, kind="response_based", **fields)
    return IterativeReply.of(result, entry, kind="iterative", mac=result.mac.by_name, **fields)


def _direct_reply(result: DirectResult, entry: Entry) -> Any:
    return DirectReply.of(
        result,
        entry,
        kind="direct",
        n_modes=result.modes.n_used,
        frequencies=result.modes.frequencies,
        mac=result.modes.mac,
        dof_errors=result.ranked_errors,
    )


def _location_reply(result: LocationResult, entry: Entry) -> Any:
    return ErrorLocationReply.of(
        result,
        entry,
        kind="error_location",
        frequencies={"measured": result.measured, "before": result.frequencies},
        mac={"before": result.mac},
    )
