"""Python client of the modallab service: `ModalLab`, and `AsyncModalLab` with `await`."""

from modallab_client import errors
from modallab_client._async.client import AsyncModalLab
from modallab_client._async.jobs import AsyncJob
from modallab_client._sync.client import ModalLab
from modallab_client._sync.jobs import Job
from modallab_client.correlation import Expansion, ReducedModel
from modallab_client.errors import ClientError, JobFailedError, JobTimeoutError, PlausibilityWarning
from modallab_client.methods.updates import Update
from modallab_client.results import Correlation, Diagnosis, Measurement, ModalModel, Rig, Structure, Study
from modallab_client.saving import load, save

__all__ = [
    "AsyncJob",
    "AsyncModalLab",
    "ClientError",
    "Correlation",
    "Diagnosis",
    "Expansion",
    "Job",
    "JobFailedError",
    "JobTimeoutError",
    "Measurement",
    "ModalLab",
    "ModalModel",
    "PlausibilityWarning",
    "ReducedModel",
    "Rig",
    "Structure",
    "Study",
    "Update",
    "errors",
    "load",
    "save",
]
