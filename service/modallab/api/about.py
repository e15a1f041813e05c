"""The service itself: is it well, which version is it."""

import platform

import numpy as np
import scipy
from fastapi import APIRouter

import modallab
from modallab.api.wire import Reply

router = APIRouter(tags=["service"])


class HealthOut(Reply):
    """The service answers."""

    status: str
    """`ok`"""


class VersionOut(Reply):
    """What a result has to be compared with if it is to come out the same."""

    version: str
    """version of the service"""
    python: str
    """version of Python"""
    numpy: str
    """version of NumPy"""
    scipy: str
    """version of SciPy"""


@router.get("/health", summary="Get the health of the service")
async def get_health() -> HealthOut:
    """Return `ok` while the service runs."""
    return HealthOut(status="ok")


@router.get("/version", summary="Get versions")
async def get_version() -> VersionOut:
    """Return the versions of the service and of its numerical libraries."""
    return VersionOut(
        version=modallab.__version__,
        python=platform.python_version(),
        numpy=np.__version__,
        scipy=scipy.__version__,
    )
