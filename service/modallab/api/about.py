"""Health and versions of the service."""

import platform

import numpy as np
import scipy
from fastapi import APIRouter

import modallab
from modallab.api.wire import Reply

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


@router.get("/version", summary="Get versions")
async def get_version() -> Versions:
    """Return the versions of the service and of its numerical libraries."""
    return Versions(
        version=modallab.__version__,
        python=platform.python_version(),
        numpy=np.__version__,
        scipy=scipy.__version__,
    )
