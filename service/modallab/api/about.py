"""The service itself: is it well, which version is it."""

import platform

import numpy as np
import scipy
from fastapi import APIRouter
from pydantic import BaseModel

import modallab

router = APIRouter(tags=["service"])


class HealthOut(BaseModel):
    """The service answers."""

    status: str


class VersionOut(BaseModel):
    """What a result has to be compared with if it is to come out the same."""

    version: str
    python: str
    numpy: str
    scipy: str


@router.get("/health", summary="Is the service up")
async def get_health() -> HealthOut:
    return HealthOut(status="ok")


@router.get("/version", summary="Versions of the service and of what it computes with")
async def get_version() -> VersionOut:
    return VersionOut(
        version=modallab.__version__,
        python=platform.python_version(),
        numpy=np.__version__,
        scipy=scipy.__version__,
    )
