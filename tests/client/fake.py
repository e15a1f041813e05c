"""A stand-in for the service: scripted replies, and a record of what was asked."""

import io
import json
from collections.abc import Callable, Mapping
from typing import Any

import httpx
import numpy as np

Reply = httpx.Response | Callable[[httpx.Request], httpx.Response]


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
    text = ": hello\n\n" + "".join(f"data: {json.dumps(state)}\n\n" for state in states)
    return httpx.Response(200, content=text, headers={"content-type": "text/event-stream"})


class FakeService:
    """Replies by `METHOD /path`; a list is used up one by one, its last reply stays."""

    def __init__(self) -> None:
        self.replies: dict[str, list[Reply]] = {}
        self.requests: list[httpx.Request] = []

    def on(self, what: str, *replies: Reply | Mapping[str, Any]) -> "FakeService":
        """Set the replies to `what`; a mapping is sent as JSON."""
        self.replies[what] = [
            httpx.Response(200, json=dict(reply)) if isinstance(reply, Mapping) else reply
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

MODE = {
    "frequency": 23.61,
    "loss_factor": 0.0051,
    "frequency_spread": {"min": 23.5, "max": 23.7, "mean": 23.61, "sd": 0.05, "n": 11},
    "loss_factor_spread": {"min": 0.005, "max": 0.0052, "mean": 0.0051, "sd": 1e-4, "n": 11},
    "standard_errors": {"frequency": 0.015},
    "flags": [],
}

DIAGNOSIS = {
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
}

UPDATE = {
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
}
