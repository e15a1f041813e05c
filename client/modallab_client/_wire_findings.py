"""JSON and npz to updates and diagnoses; pure."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, TypeVar

from modallab_client import _wire_direct, findings, identified, located
from modallab_client._wire import Arrays, Json, floats, number, texts

T = TypeVar("T")


def update(data: Json) -> findings.Update:
    """Return an update."""
    return findings.Update(
        id=data["id"],
        converged=bool(data["converged"]),
        stopped_because=data["stopped_because"],
        iterations=dict(data.get("iterations") or {}),
        coefficients=_by_member(data["coefficients"]),
        standard_errors=_by_member(data.get("standard_errors") or {}),
        suspected={part: tuple(map(int, found)) for part, found in (data.get("suspected") or {}).items()},
        frequencies=_curves(data.get("frequencies")),
        mac=_curves(data.get("mac")),
        rank=data.get("rank"),
        condition_number=data.get("condition_number"),
        structure_id=data.get("structure_id"),
        history=tuple(_iteration(one) for one in data.get("history") or ()),
        intervals={
            part: {int(member): (float(low), float(high)) for member, (low, high) in found.items()}
            for part, found in (data.get("intervals") or {}).items()
        },
        identifiability=_identifiability(data["identifiability"]) if data.get("identifiability") else None,
        quantities=tuple(_quantity(one) for one in data.get("quantities") or ()),
        posterior=_posterior(data["posterior"]) if data.get("posterior") else None,
        responses=_responses(data["responses"]) if data.get("responses") else None,
        direct=_wire_direct.findings(data["direct"]) if data.get("direct") else None,
        suspects=_wire_direct.suspects(data["located"]) if data.get("located") else None,
    )


def _responses(data: Json) -> identified.Responses:
    plain = {name: data[name] for name in ("before", "after", "scatter", "n_lines", "n_held_out")}
    return identified.Responses(
        **plain,
        band=(float(data["band"][0]), float(data["band"][1])),
        held_out_before=data.get("held_out_before"),
        held_out_after=data.get("held_out_after"),
        outputs=tuple(data["outputs"]),
        inputs=tuple(data["inputs"]),
        by_frf_before=floats(data["by_frf_before"]),
        by_frf_after=floats(data["by_frf_after"]),
    )


def _identifiability(data: Json) -> identified.Identifiability:
    return identified.Identifiability(
        rank=data["rank"],
        condition_number=data.get("condition_number"),
        singular_values=floats(data["singular_values"]),
        unidentified={part: tuple(map(int, found)) for part, found in data["unidentified"].items()},
        directions=tuple(
            identified.Direction(
                words=one["words"],
                standard_error=one.get("standard_error"),
                shares=tuple(
                    identified.Share(each["part"], tuple(map(int, each["members"])), each["share"])
                    for each in one["shares"]
                ),
            )
            for one in data["directions"]
        ),
    )


def _quantity(data: Json) -> identified.Quantity:
    interval = data.get("interval")
    return identified.Quantity(
        part=data["part"],
        members=tuple(map(int, data["members"])),
        unit=data["unit"],
        before=float(data["before"]),
        after=float(data["after"]),
        interval=None if interval is None else (float(interval[0]), float(interval[1])),
    )


def covariance(given: Arrays) -> identified.Covariance:
    """Return the covariance of an update's coefficients."""
    names = texts(given["coefficients"])
    return identified.Covariance(names, given["intervals"], given.get("covariance"))


def _posterior(data: Json) -> identified.Posterior:
    return identified.Posterior(
        n_draws=data["n_draws"],
        n_chains=data["n_chains"],
        acceptance=data["acceptance"],
        coefficients=tuple(
            identified.Drawn(
                part=one["part"],
                members=tuple(map(int, one["members"])),
                mean=one["mean"],
                standard_deviation=one["standard_deviation"],
                interval=(float(one["interval"][0]), float(one["interval"][1])),
                effective=one["effective"],
            )
            for one in data["coefficients"]
        ),
    )


def sample(given: Arrays) -> identified.Sample:
    """Return draws from the posterior of an update."""
    return identified.Sample(texts(given["coefficients"]), given["draws"], given["log_density"])


def _iteration(data: Json) -> findings.Iteration:
    return findings.Iteration(
        stage=data["stage"],
        coefficients=tuple(
            findings.MacroCoefficient(one["part"], tuple(map(int, one["members"])), one["value"])
            for one in data["coefficients"]
        ),
        max_change=data.get("max_change"),
        rank=data.get("rank"),
        condition_number=data.get("condition_number"),
        frequencies=floats(data["frequencies"]),
        mac=floats(data["mac"]),
    )


def _by_member(parts: Json) -> dict[str, dict[int, float]]:
    return {
        part: {
            int(member): float("nan") if value is None else float(value) for member, value in found.items()
        }
        for part, found in parts.items()
    }


def _curves(data: Json | None) -> dict[str, Any]:
    return {name: floats(values) for name, values in (data or {}).items() if values is not None}


def diagnosis(data: Json) -> findings.Diagnosis:
    """Return a diagnosis."""
    following = data.get("next_test")
    return findings.Diagnosis(
        id=data["id"],
        verdict=data["verdict"],
        located=_located(data.get("located") or {}),
        steps=tuple(_step(one) for one in data["steps"]),
        remaining_gap=data.get("remaining_gap"),
        gaps=dict(data.get("gaps") or {}),
        next_test=_next_test(following) if following else None,
        structure_id=data.get("structure_id"),
        rig_id=data.get("rig_id"),
        remaining_scatter=data.get("remaining_scatter"),
        follow_ups=tuple(
            findings.FollowUp(one["measurement_id"], one.get("changed") or {})
            for one in data.get("follow_ups") or ()
        ),
        notes=texts(data.get("notes") or ()),
        tolerated=tuple(_tolerated(one) for one in data.get("tolerated") or ()),
    )


def _located(data: Json) -> located.Located:
    return located.Located(
        bands=tuple((float(low), float(high)) for low, high in data.get("bands", ())),
        dofs=texts(data.get("dofs", ())),
        modes=tuple(map(int, data.get("modes", ()))),
        words=texts(data.get("words", ())),
        signs=texts(data.get("signs", ())),
        mode_shifts=tuple(_known(located.ModeShift, one) for one in data.get("mode_shifts", ())),
        responses=tuple(_known(located.ResponseMisfit, one) for one in data.get("responses", ())),
        level_dependence=data.get("level_dependence"),
    )


def _known(cls: type[T], data: Json) -> T:
    """Return the fields of a reply that a result knows; later versions may say more."""
    return cls(**{one.name: data.get(one.name) for one in fields(cls)})  # type: ignore[arg-type]


def _tolerated(data: Json) -> findings.Tolerated:
    return findings.Tolerated(
        name=data["name"],
        value=float(data["value"]),
        standard_error=data.get("standard_error"),
        tolerance=float(data["tolerance"]),
        unit=data.get("unit") or "",
        at=data.get("at"),
        mode=data.get("mode"),
    )


def _next_test(data: Json) -> findings.NextTest:
    return findings.NextTest(
        why=data["why"],
        change=data.get("change") or {},
        separates=texts(data.get("separates") or ()),
        expected_separation=data.get("expected_separation"),
    )


def _step(data: Json) -> findings.Step:
    return findings.Step(
        effect=_effect(data["effect"]),
        probability=data.get("probability"),
        gap_before=number(data["gap_before"]),
        gap_after=number(data["gap_after"]),
        held_out_gap_before=data.get("held_out_gap_before"),
        held_out_gap_after=data.get("held_out_gap_after"),
        held_out_scatter=data.get("held_out_scatter"),
        rivals=tuple(_rival(one) for one in data.get("rivals") or ()),
        rivals_alike=tuple(_rival(one) for one in data.get("rivals_alike") or ()),
    )


def _effect(data: Json) -> findings.FittedEffect:
    parameters: Mapping[str, Json] = data.get("parameters") or {}
    return findings.FittedEffect(
        kind=data["kind"],
        at=data.get("at"),
        parameters={
            name: findings.Parameter(one["value"], one.get("standard_error"), one.get("unit") or "")
            for name, one in parameters.items()
        },
    )


def _rival(data: Json) -> findings.Rival:
    return findings.Rival(data["kind"], data.get("at"), data.get("probability"), data.get("gap_after"))


def diagnosis_curves(given: Arrays) -> findings.DiagnosisCurves:
    """Return the FRFs of a diagnosis."""
    return findings.DiagnosisCurves(
        freq=given["freq"],
        measured=given["measured"],
        before=given["before"],
        after=given["after"],
        random_error=given["random_error"],
        held_out=given["held_out"],
        outputs=texts(given["outputs"]),
        inputs=texts(given["inputs"]),
        predicted=given.get("predicted"),
        predicted_outputs=texts(given.get("predicted_outputs", ())),
    )
