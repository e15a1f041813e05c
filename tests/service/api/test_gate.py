"""Without keys everybody on this machine is let in, and no web page of another origin."""

from pathlib import Path
from typing import Any

import httpx
import pytest
from anyio.from_thread import start_blocking_portal

from modallab.api.app import create_app
from modallab.api.runners import job_book
from modallab.api.settings import ServiceSettings
from modallab.jobs.inline import InlineRunner
from modallab.store.keys import Role
from tests.service.api.conftest import Service

BEAM = {"kind": "catalogue", "name": "bay"}


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://elsewhere.example"},
        {"Origin": "https://localhost"},
        {"Origin": "null"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
        {"Authorization": "Basic eDp4", "Origin": "http://elsewhere.example"},
    ],
)
def test_pages_of_other_origins_change_nothing(service: Any, headers: dict[str, str]) -> None:
    reply = service.request("POST", "/v1/structures", json=BEAM, headers=headers)
    assert (reply.status_code, reply.json()["code"]) == (403, "forbidden")
    assert reply.headers["content-type"] == "application/problem+json"
    assert service.request("GET", "/v1/structures", headers=headers).status_code == 200


@pytest.mark.parametrize(
    "headers",
    [{}, {"Origin": "http://localhost:8000"}, {"Sec-Fetch-Site": "same-origin"}, {"Sec-Fetch-Site": "none"}],
)
def test_own_pages_and_programs_change_what_they_want(service: Any, headers: dict[str, str]) -> None:
    assert service.request("POST", "/v1/structures", json=BEAM, headers=headers).status_code == 201


@pytest.mark.parametrize("host", ["localhost:8000", "127.0.0.1", "[::1]:8000", "LOCALHOST"])
def test_this_machine_is_asked_by_its_own_names(service: Any, host: str) -> None:
    assert service.request("GET", "/v1/structures", headers={"Host": host}).status_code == 200


@pytest.mark.parametrize("host", ["rebound.example:8000", "localhost.example", "", "127.0.0.1.example"])
def test_and_by_no_other(service: Any, host: str) -> None:
    reply = service.request("GET", "/v1/structures", headers={"Host": host})
    assert (reply.status_code, reply.json()["context"]["field"]) == (403, "Host")


def test_keys_are_made_by_the_command_first(service: Any) -> None:
    key = {"name": "somebody", "role": "admin"}
    for method, path in (("POST", "/v1/keys"), ("GET", "/v1/keys"), ("GET", "/v1/classes")):
        reply = service.request(method, path, **({"json": key} if method == "POST" else {}))
        assert (reply.status_code, reply.json()["code"]) == (403, "forbidden")
        assert "modallab keys create --role admin" in reply.json()["detail"]


def test_a_key_is_not_looked_at_where_there_are_none(service: Any) -> None:
    reply = service.request("GET", "/v1/structures", headers={"Authorization": "Bearer whatever"})
    assert reply.status_code == 200


def names(**given: Any) -> Any:
    return ServiceSettings(**given).host_names


def test_which_names_a_service_without_keys_has(monkeypatch: pytest.MonkeyPatch) -> None:
    own = ("localhost", "127.0.0.1", "[::1]")
    assert names() == names(host="::1") == names(host="localhost") == own
    assert names(host="0.0.0.0") is None
    monkeypatch.setenv("MODALLAB_ALLOWED_HOSTS", "Lab, lab.example")
    assert names() == names(host="0.0.0.0") == (*own, "lab", "lab.example")


def test_a_body_without_a_key_is_not_read(tmp_path: Path) -> None:
    settings = ServiceSettings(data=tmp_path)
    settings.store_place.prepare()
    app = create_app(settings, InlineRunner(job_book(settings), settings.store_place))
    app.state.keys.create("root", Role.ADMIN)
    read: list[bytes] = []

    async def body() -> Any:
        for part in (b"{", b"}"):
            read.append(part)
            yield part

    with start_blocking_portal() as portal:
        reply: httpx.Response = Service(app, portal).request("POST", "/v1/structures", content=body())
    assert reply.status_code == 401
    assert read == []
