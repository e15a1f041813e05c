"""Health and versions of the service."""

import platform
from shutil import disk_usage

import numpy as np
import scipy
from fastapi import APIRouter

import modallab
from modallab.api.deps import JobsDep, SettingsDep, StoreDep
from modallab.api.limits import READINESS
from modallab.api.wire import Reply
from modallab.jobs.runner import NotReadyError

router = APIRouter(tags=["service"])


class Health(Reply):
    """Health of the service."""

    status: str
    """`ok`"""


class Versions(Reply):
    """Versions of the service and of the libraries that its figures depend on."""

    version: str
    """version of the service"""
    python: str
    """version of Python"""
    numpy: str
    """version of NumPy"""
    scipy: str
    """version of SciPy"""


@router.get("/health", summary="Get the health of the service")
async def get_health() -> Health:
    """Return `ok` while the service runs."""
    return Health(status="ok")


class Ready(Reply):
    """What the service needs, each found."""

    status: str
    """`ready`"""
    database: bool
    """whether the database answers"""
    disk: bool
    """whether the disk has room"""
    worker: bool
    """whether a process lives that runs jobs"""


@router.get("/ready", summary="Get whether the service can work")
def get_ready(jobs: JobsDep, store: StoreDep, settings: SettingsDep) -> Ready:
    """Return `ready` if database, disk and workers are there; else 503 with what is missing."""
    store.structures.list(limit=1)  # an error of the database is answered with 503
    room = disk_usage(settings.data).free
    found = {"database": True, "disk": room >= READINESS.least_room, "worker": jobs.is_served()}
    if missing := [name for name, there in found.items() if not there]:
        raise NotReadyError(f"the service cannot work: {', '.join(missing)}", free_bytes=room, **found)
    return Ready(status="ready", **found)


@router.get("/version", summary="Get versions")
async def get_version() -> Versions:
    """Return the versions of the service and of its numerical libraries."""
    return Versions(
        version=modallab.__version__,
        python=platform.python_version(),
        numpy=np.__version__,
        scipy=scipy.__version__,
    )
