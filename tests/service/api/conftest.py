"""The service in this process: its jobs at once, its data in a folder of the test's own."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import httpx
import pytest
from anyio.from_thread import BlockingPortal, start_blocking_portal
from fastapi import FastAPI

from modallab.api.app import create_app
from modallab.api.runners import job_book
from modallab.api.settings import ServiceSettings
from modallab.jobs import sealing
from modallab.jobs.inline import InlineRunner


class Service:
    """Sends requests to an application, synchronously."""

    def __init__(self, app: FastAPI, portal: BlockingPortal) -> None:
        self.app, self._portal = app, portal
        # Faults of ours shall come back as the 500 a client would see.
        self._transport = httpx.ASGITransport(app, raise_app_exceptions=False)

    def request(self, method: str, path: str, **given: Any) -> httpx.Response:
        """Return the reply to a request."""

        async def send() -> httpx.Response:
            async with httpx.AsyncClient(
                transport=self._transport, base_url="http://localhost:8000"
            ) as client:
                return await client.request(method, path, **given)

        return self._portal.call(send)

    def get(self, path: str, **given: Any) -> Any:
        """Return the JSON of a reply that must be good."""
        reply = self.request("GET", path, **given)
        assert reply.status_code == 200, reply.text
        return reply.json()

    def post(self, path: str, body: Any, status: int = 201) -> Any:
        """Return the JSON of a reply that must have this status."""
        reply = self.request("POST", path, json=body)
        assert reply.status_code == status, reply.text
        return reply.json()

    def result_of(self, path: str, body: Any) -> str:
        """Return the id of what a job has made."""
        job = self.get(f"/v1/jobs/{self.post(path, body, status=202)['id']}")
        assert job["state"] == "succeeded", job
        return str(job["result_id"])


@pytest.fixture(scope="module")
def unpadded() -> Iterator[None]:
    """Measurements of assignments that end when they are done."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sealing, "SEALING", replace(sealing.SEALING, step=0.0))
        yield


@pytest.fixture(scope="module")
def settings(tmp_path_factory: pytest.TempPathFactory) -> ServiceSettings:
    """Settings of a service with an empty folder."""
    return ServiceSettings(data=tmp_path_factory.mktemp("data"))


@contextmanager
def service_of(settings: ServiceSettings) -> Iterator[Service]:
    """Return a service with the data of the settings, its jobs at once."""
    settings.store_place.prepare()
    app = create_app(settings, InlineRunner(job_book(settings), settings.store_place))
    with start_blocking_portal() as portal:
        yield Service(app, portal)


@pytest.fixture(scope="module")
def service(settings: ServiceSettings) -> Iterator[Service]:
    """A service with nothing in it, the same for the tests of a file."""
    with service_of(settings) as running:
        yield running


@pytest.fixture(scope="module")
def beam(service: Service) -> str:
    """The chapter 5 beam's id."""
    return str(service.post("/v1/structures", {"kind": "catalogue", "name": "chapter-5-beam"})["id"])


RESPONSES = [f"{n}:+Y" for n in range(1, 22, 4)]


@pytest.fixture(scope="module")
def rig(service: Service) -> str:
    """A rig with six responses on the beam."""
    noise = {"force": 1e-3, "response": 1e-3}
    return str(service.post("/v1/rigs", {"drive": "1:+Y", "responses": RESPONSES, "noise": noise})["id"])
