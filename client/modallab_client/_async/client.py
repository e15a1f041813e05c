"""The client: one object, the service's resources as its attributes."""

import os
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import httpx

from modallab_client._async.assignments import AsyncAssignments
from modallab_client._async.catalog import AsyncCatalog
from modallab_client._async.classes import AsyncClasses, AsyncKeys
from modallab_client._async.correlations import AsyncCorrelations
from modallab_client._async.diagnoses import AsyncDiagnoses
from modallab_client._async.jobs import AsyncJobs
from modallab_client._async.measurements import AsyncMeasurements
from modallab_client._async.modal_models import AsyncModalModels
from modallab_client._async.projects import AsyncProjects
from modallab_client._async.rigs import AsyncRigs
from modallab_client._async.structures import AsyncStructures
from modallab_client._async.studies import AsyncStudies
from modallab_client._async.transport import AsyncTransport
from modallab_client._async.trash import AsyncTrash
from modallab_client._async.updates import AsyncUpdates
from modallab_client._embedded import ServiceProcess, require_service


class AsyncModalLab:
    """A modal-testing lab, reached over HTTP.

    Parameters
    ----------
    base_url
        Where the service is, `http://host:8000`.
    api_key
        Sent with every request; left out: the environment's `MODALLAB_KEY`, or none. A service on this
        machine may need none.
    http
        An own httpx client, for proxies, certificates or tests; it stays open.
    timeout
        Longest wait for one reply in s; jobs may take as long as they need.
    """

    def __init__(
        self,
        base_url: str,
        *,
        api_key: str | None = None,
        http: httpx.AsyncClient | None = None,
        timeout: float = 60.0,
    ) -> None:
        self.base_url = base_url
        key = os.environ.get("MODALLAB_KEY") if api_key is None else api_key
        self._transport = AsyncTransport(base_url, api_key=key, http=http, timeout=timeout)
        self.structures = AsyncStructures(self._transport)
        self.rigs = AsyncRigs(self._transport)
        self.measurements = AsyncMeasurements(self._transport)
        self.modal_models = AsyncModalModels(self._transport)
        self.correlations = AsyncCorrelations(self._transport)
        self.updates = AsyncUpdates(self._transport)
        self.studies = AsyncStudies(self._transport)
        self.diagnoses = AsyncDiagnoses(self._transport)
        self.jobs = AsyncJobs(self._transport)
        self.trash = AsyncTrash(self._transport)
        self.projects = AsyncProjects(self._transport)
        self.catalog = AsyncCatalog(self._transport)
        self.keys = AsyncKeys(self._transport)
        self.classes = AsyncClasses(self._transport)
        self.assignments = AsyncAssignments(self._transport)

    @classmethod
    def embedded(cls, data: str | Path | None = None, *, timeout: float = 60.0) -> Self:
        """Start the service beside this process, and return a lab that uses and ends it.

        Parameters
        ----------
        data
            Folder that keeps what is stored, for one embedded service at a time; left out: a
            temporary one.
        timeout
            Longest wait for one reply in s.

        Raises
        ------
        MissingExtraError
            If the service's packages are not installed.
        ConflictError
            If another embedded service works in that folder.
        """
        require_service()
        service = ServiceProcess(data)
        lab = cls(service.url, api_key=service.key, timeout=timeout)
        lab._transport.accompany(service)
        return lab

    async def request(
        self,
        method: str,
        path: str,
        *,
        json: Any = None,
        files: Any = None,
        data: Mapping[str, Any] | None = None,
        params: Mapping[str, Any] | None = None,
    ) -> Any:
        """Send anything, and return the reply's JSON, or its bytes where it is not JSON.

        Parameters
        ----------
        method, path
            `"POST"`, `"/v1/structures"`.
        json
            A body as JSON.
        files, data
            A multipart body: files by field name as httpx takes them, and plain fields.
        params
            The query.

        Raises
        ------
        ClientError
            The class that the problem's `code` names.
        """
        return await self._transport.request(method, path, json=json, files=files, data=data, params=params)

    async def aclose(self) -> None:
        """Close the connections, and end an embedded service."""
        await self._transport.aclose()

    async def __aenter__(self) -> Self:
        try:
            await self._transport.wait_until_ready()
        except BaseException:
            await self.aclose()
            raise
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.aclose()
