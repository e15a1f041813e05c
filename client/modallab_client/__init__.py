"""Python client of the modallab service: `ModalLab`, and `AsyncModalLab` with `await`."""

from modallab_client._async.client import AsyncModalLab
from modallab_client._async.jobs import AsyncJob
from modallab_client._sync.client import ModalLab
from modallab_client._sync.jobs import Job
from modallab_client.errors import ClientError, JobFailedError, JobTimeoutError

__all__ = [
    "AsyncJob",
    "AsyncModalLab",
    "ClientError",
    "Job",
    "JobFailedError",
    "JobTimeoutError",
    "ModalLab",
]
