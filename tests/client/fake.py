"""A stand-in for the service: scripted replies, and a record of what was asked."""

import io
import json
import re
import types
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import httpx
import numpy as np

from modallab_client import results
from modallab_client._generated.models import Page

Reply = httpx.Response | Callable[[httpx.Request], httpx.Response]


def completed(kind: Any, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the JSON of a result type: plain values stand in the required fields that are not given."""
    reply = dict(given)
    for field in fields(kind):
        hint = get_type_hints(kind)[field.name]
        if field.name in given:
            reply[field.name] = _completed(hint, given[field.name])
        elif field.default is MISSING and field.default_factory is MISSING:
            reply[field.name] = _plain(hint)
    return reply


def _completed(hint: Any, given: Any) -> Any:
    """Return a given value, the objects in it completed."""
    origin, options = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        objects = [option for option in options if is_dataclass(option)]
        return _completed(objects[0], given) if len(objects) == 1 else given
    if is_dataclass(hint) and isinstance(given, Mapping):
        return completed(hint, given)
    if origin is tuple and isinstance(given, (list, tuple)):
        return [_completed(options[0], item) for item in given]
    if isinstance(origin, type) and issubclass(origin, Mapping) and isinstance(given, Mapping):
        return {name: _completed(options[1], item) for name, item in given.items()}
    return given


def _plain(hint: Any) -> Any:
    """Return the plainest value that a type allows."""
    origin, options = get_origin(hint), get_args(hint)
    if type(None) in options:
        return None
    if origin is Literal:
        return options[0]
    if is_dataclass(hint):
        return completed(hint, {})
    if origin is tuple and Ellipsis not in options:
        return [_plain(option) for option in options]
    if isinstance(origin, type):
        return {} if issubclass(origin, Mapping) else []
    return {str: "", bool: False, int: 0, float: 0.0, complex: [0.0, 0.0]}[hint]


def problem(status: int, code: str, detail: str, **context: Any) -> httpx.Response:
    """Return a problem document as the service sends it."""
    body = {"type": f"/problems/{code}", "title": "T", "status": status, "detail": detail, "code": code}
    text = json.dumps({**body, "context": context, "instance": "/v1/x", "new_field": 1})
    return httpx.Response(status, content=text, headers={"content-type": "application/problem+json"})


def npz(**arrays: Any) -> httpx.Response:
    """Return an npz reply."""
    file = io.BytesIO()
    np.savez(file, **arrays)
    return httpx.Response(200, content=file.getvalue(), headers={"content-type": "application/octet-stream"})


def events(*states: Mapping[str, Any]) -> httpx.Response:
    """Return an event stream that ends after these states."""
    sent = [completed(results.JobStatus, state) if state else {} for state in states]
    text = ": hello\n\n" + "".join(f"data: {json.dumps(state)}\n\n" for state in sent)
    return httpx.Response(200, content=text, headers={"content-type": "text/event-stream"})


# Result types of the replies to `METHOD /path`.
TYPES = {
    r"GET /v1/(structures|rigs|measurements|modal-models|correlations|updates|studies|diagnoses)": Page,
    r"(GET|POST) /v1/structures(/import|/\w+|/\w+/changes)?": results.Structure,
    r"GET /v1/structures/\w+/modes": results.StructureModes,
    r"(GET|POST) /v1/rigs(/\w+)?": results.Rig,
    r"GET /v1/measurements/\w+|POST /v1/measurements/import": results.Measurement,
    r"GET /v1/measurements/\w+/log": results.MeasurementLog,
    r"GET /v1/measurements/\w+/truth": results.Truth,
    r"GET /v1/measurements/\w+/indicators": results.Indicators,
    r"GET /v1/measurements/\w+/reciprocity": results.ReciprocityCheck,
    r"GET /v1/modal-models/\w+|POST /v1/modal-models/import": results.ModalModel,
    r"POST /v1/structures/\w+/(expanded|synthetic)-modes": results.ModalModel,
    r"GET /v1/modal-models/\w+/fits": results.FitPlotData,
    r"GET /v1/modal-models/\w+/chart": results.StabilisationChart,
    r"GET /v1/modal-models/\w+/reciprocity": results.ModalReciprocityCheck,
    r"(GET|POST) /v1/correlations(/\w+)?": results.Correlation,
    r"GET /v1/diagnoses/\w+": results.Diagnosis,
    r"GET /v1/studies/\w+": results.Study,
    r"(GET|DELETE) /v1/jobs/\w+": results.JobStatus,
    r"POST /v1/(measurements|modal-models|updates|studies|diagnoses)": results.JobStatus,
}


def whole(what: str, reply: Mapping[str, Any]) -> dict[str, Any]:
    """Return the JSON of the reply to `METHOD /path`, completed."""
    kind = next((kind for pattern, kind in TYPES.items() if re.fullmatch(pattern, what)), None)
    return dict(reply) if kind is None or not reply else completed(kind, reply)


class FakeService:
    """Replies by `METHOD /path`; a list is used up one by one, its last reply stays."""

    def __init__(self) -> None:
        self.replies: dict[str, list[Reply]] = {}
        self.requests: list[httpx.Request] = []

    def on(self, what: str, *replies: Reply | Mapping[str, Any]) -> "FakeService":
        """Set the replies to `what`; a mapping is sent as JSON."""
        self.replies[what] = [
            httpx.Response(200, json=whole(what, reply)) if isinstance(reply, Mapping) else reply
            for reply in replies
        ]
        return self

    def __call__(self, request: httpx.Request) -> httpx.Response:
        request.read()
        self.requests.append(request)
        waiting = self.replies[f"{request.method} {request.url.path}"]
        reply = waiting.pop(0) if len(waiting) > 1 else waiting[0]
        if callable(reply):
            return reply(request)
        # a copy: a response can be read once
        return httpx.Response(reply.status_code, headers=reply.headers, content=reply.content)

    def body(self, index: int = -1) -> Any:
        """Return the JSON of a request."""
        return json.loads(self.requests[index].content)

    def asked(self, what: str) -> int:
        """Return how often `METHOD /path` was asked."""
        return sum(f"{r.method} {r.url.path}" == what for r in self.requests)


MEASUREMENT = {
    "freq": np.array([0.0, 2.0, 4.0]),
    "values": np.arange(6).reshape(3, 2, 1) * (1 + 1j),
    "coherence": np.ones((3, 2)),
    "outputs": np.array(["1:+Y", "3:+Y"]),
    "inputs": np.array(["1:+Y"]),
    "kind": np.array("inertance"),
    "averages": np.array(100.0),
    "force_spectrum": np.ones((3, 2, 1)),
    "response_spectrum": np.ones((3, 2)),
}

MODE = completed(
    results.Mode,
    {
        "frequency": 23.61,
        "loss_factor": 0.0051,
        "frequency_spread": {"min": 23.5, "max": 23.7, "mean": 23.61, "sd": 0.05, "n": 11},
        "loss_factor_spread": {"min": 0.005, "max": 0.0052, "mean": 0.0051, "sd": 1e-4, "n": 11},
        "standard_errors": {"frequency": 0.015},
        "flags": [],
    },
)

DIAGNOSIS = completed(
    results.Diagnosis,
    {
        "id": "d1",
        "verdict": "explained",
        "located": {"bands": [[22.0, 24.0]], "dofs": ["11:+Y"], "modes": [1]},
        "steps": [
            {
                "effect": {
                    "kind": "extra_mass",
                    "at": "7:+Y",
                    "parameters": {"mass": {"value": 0.05, "standard_error": 0.0004, "unit": "kg"}},
                },
                "probability": 0.997,
                "gap_before": 812.0,
                "gap_after": 1.04,
                "held_out_gap_before": 790.0,
                "held_out_gap_after": 1.06,
                "rivals": [
                    {"kind": "density_error", "at": {"members": [3]}, "probability": 0.002, "gap_after": 31.0}
                ],
                "rivals_alike": [{"kind": "force_transducer_mass", "at": None}],
            }
        ],
        "remaining_gap": 1.06,
        "remaining_scatter": 0.02,
        "notes": ["n"],
        "gaps": {"before": {"frf": 812.0}, "after": {"frf": 1.04}},
        "next_test": {
            "why": "w",
            "change": {"level_factor": 3.0},
            "separates": ["a", "b"],
            "expected_separation": 12.5,
        },
        "follow_ups": [{"measurement_id": "m2", "changed": {"drive": "5:+Y"}}],
        "structure_id": "s2",
        "rig_id": "r2",
    },
)

UPDATE = completed(
    results.IterativeUpdate,
    {
        "id": "u1",
        "kind": "iterative",
        "converged": True,
        "stopped_because": "the coefficients stand still",
        "iterations": {"location": 4, "updating": 6},
        "coefficients": {"mass": {"1": 2.0}, "stiffness": {"11": 2.0, "12": 1.99}},
        "standard_errors": {"mass": {"1": 0.01}, "stiffness": {"11": 0.02, "12": None}},
        "suspected": {"mass": [1, 2], "stiffness": [11, 12]},
        "frequencies": {
            "measured": [22.1, 61.0],
            "before": [23.0, 63.0],
            "location": [22.0, 60.0],
            "after": [22.1, 61.0],
        },
        "mac": {"before": [0.9, 0.95], "after": [1.0, 1.0]},
        "rank": 8,
        "condition_number": 120.0,
        "structure_id": "s9",
        "history": [
            {
                "stage": "location",
                "max_change": 0.4,
                "rank": 8,
                "condition_number": None,
                "singular_values": [12.0, 0.1],
                "macros": [{"part": "mass", "members": [1, 2]}],
                "step": [0.4],
                "coefficients": [1.6],
                "frequencies": [22.4, 61.2],
                "mac": [0.99, 0.98],
            }
        ],
    },
)
