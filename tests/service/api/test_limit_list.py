"""The list of limits: complete, unique, and those that count."""

from dataclasses import fields
from typing import Any

from modallab.api.limits import REPLY, REQUEST
from modallab.api.settings import ServiceSettings


def test_limits_are_those_that_count(service: Any, settings: ServiceSettings) -> None:
    limits = {limit["name"]: limit for limit in service.get("/v1/limits")["items"]}
    assert len(limits) == len(service.get("/v1/limits")["items"])
    assert {f.name for group in (REQUEST, REPLY) for f in fields(group)} <= set(limits)
    assert limits["job_seconds"]["value"] == settings.job_seconds
    assert limits["plate_elements"] == {
        "name": "plate_elements",
        "value": 40_000,
        "unit": "elements",
        "doc": "elements of a plate from the catalogue",
    }
    assert all(limit["unit"] and limit["doc"] for limit in limits.values())
