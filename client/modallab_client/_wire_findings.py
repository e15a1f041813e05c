"""JSON and npz to updates; pure."""

from typing import Any, TypeVar

from modallab_client import _wire_direct, findings, identified
from modallab_client._wire import Arrays, Json, floats, texts

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
