"""Limits of the service as a list, for whoever plans requests."""

from collections.abc import Iterator
from dataclasses import asdict

from fastapi import APIRouter

from modallab.api.deps import SettingsDep
from modallab.api.limits import REPLY, REQUEST
from modallab.api.offloading.settings import OFFLOADING
from modallab.api.projects.settings import PROJECT
from modallab.api.settings import ServiceSettings
from modallab.api.wire import Reply
from modallab.interchange.settings import CONFINEMENT
from modallab.jobs.settings import JOB
from modallab.rig.record_settings import RECORDS

router = APIRouter(tags=["service"])
_JOB = ("max_attempts", "time_limit", "further_tests")
_OFFLOADING = ("light", "resident_bytes", "processor_seconds", "seconds", "file_seconds", "waiting_seconds")
_SERVICE = {
    "queue_length": "jobs",
    "key_queue_length": "jobs",
    "class_queue_length": "jobs",
    "key_stored_bytes": "bytes",
    "class_stored_bytes": "bytes",
    "job_seconds": "s",
    "body_limit": "bytes",
    "upload_limit": "bytes",
}


class LimitReply(Reply):
    """A limit: what exceeds it is refused."""

    name: str
    """name of the limit, unique in the list"""
    value: float
    """largest value allowed, in its unit"""
    unit: str
    """unit, or what is counted"""
    doc: str
    """meaning"""


class LimitList(Reply):
    """The limits of this service."""

    items: list[LimitReply]
    """limits"""


@router.get("/limits", summary="List limits")
async def list_limits(settings: SettingsDep) -> LimitList:
    """Return the limits of requests, replies, files and jobs of this service."""
    return LimitList(items=list(_limits(settings)))


def _limits(settings: ServiceSettings) -> Iterator[LimitReply]:
    for name, unit in _SERVICE.items():
        doc = ServiceSettings.model_fields[name].description or name
        yield LimitReply(name=name, value=getattr(settings, name), unit=unit, doc=doc)
    groups = (
        (REQUEST, None),
        (REPLY, None),
        (JOB, _JOB),
        (OFFLOADING, _OFFLOADING),
        (CONFINEMENT, ("max_bytes",)),
        (RECORDS, ("kept_samples", "kept_estimate_values")),
        (PROJECT, ("max_things",)),
    )
    for group, names in groups:
        values, specs = asdict(group), group.specs()
        for name in names or specs:
            yield LimitReply(name=name, value=values[name], unit=specs[name].unit, doc=specs[name].doc)
