"""The client: one object, the service's resources as its attributes."""

import os
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import httpx

from modallab_client._embedded import ServiceProcess, require_service
from modallab_client._sync.assignments import Assignments
from modallab_client._sync.catalog import Catalog
from modallab_client._sync.classes import Classes, Keys
from modallab_client._sync.correlations import Correlations
from modallab_client._sync.diagnoses import Diagnoses
from modallab_client._sync.jobs import Jobs
from modallab_client._sync.measurements import Measurements
from modallab_client._sync.modal_models import ModalModels
from modallab_client._sync.projects import Projects
from modallab_client._sync.rigs import Rigs
from modallab_client._sync.structures import Structures
from modallab_client._sync.studies import Studies
from modallab_client._sync.transport import Transport
from modallab_client._sync.trash import Trash
from modallab_client._sync.updates import Updates


class ModalLab:
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
        http: httpx.Client | None = None,
        timeout: float = 60.0,
    ) -> None:
        self.base_url = base_url
        key = os.environ.get("MODALLAB_KEY") if api_key is None else api_key
        self._transport = Transport(base_url, api_key=key, http=http, timeout=timeout)
        self.structures = Structures(self._transport)
        self.rigs = Rigs(self._transport)
        self.measurements = Measurements(self._transport)
        self.modal_models = ModalModels(self._transport)
        self.correlations = Correlations(self._transport)
        self.updates = Updates(self._transport)
        self.studies = Studies(self._transport)
        self.diagnoses = Diagnoses(self._transport)
        self.jobs = Jobs(self._transport)
        self.trash = Trash(self._transport)
        self.projects = Projects(self._transport)
        self.catalog = Catalog(self._transport)
        self.keys = Keys(self._transport)
        self.classes = Classes(self._transport)
        self.assignments = Assignments(self._transport)

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

    def request(
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
        return self._transport.request(method, path, json=json, files=files, data=data, params=params)

    def close(self) -> None:
        """Close the connections, and end an embedded service."""
        self._transport.close()

    def __enter__(self) -> Self:
        try:
            self._transport.wait_until_ready()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
