"""What goes over the wire, what comes back, and what is asked twice."""

import asyncio

import httpx
import pytest

from modallab_client import AsyncModalLab, ClientError, ModalLab, errors, results
from tests.client.fake import FakeService, completed, problem

RIG = completed(results.Rig, {"id": "r1"})


def test_the_key_and_the_body_arrive_as_given(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/rigs", {"id": "r1", "a_later_field": [1, 2]})
    rig = lab.rigs.create(drive="1:+Y", responses=["1:+Y"], exciter={"kind": "shaker"})
    assert rig.id == "r1"
    assert service.body() == {"drive": "1:+Y", "responses": ["1:+Y"], "exciter": {"kind": "shaker"}}
    assert service.requests[0].headers["authorization"] == "Bearer secret"
    assert str(service.requests[0].url) == "http://lab:8000/v1/rigs"


def test_request_returns_json_bytes_or_nothing(lab: ModalLab, service: FakeService) -> None:
    service.on("GET /v1/health", {"status": "ok"})
    page = httpx.Response(200, content=b"<html>", headers={"content-type": "text/html; charset=utf-8"})
    service.on("GET /v1/diagnoses/d1/report", page)
    service.on("DELETE /v1/rigs/r1", httpx.Response(204))
    assert lab.request("GET", "/v1/health", params={"a": 1}) == {"status": "ok"}
    assert service.requests[0].url.query == b"a=1"
    assert lab.request("GET", "/v1/diagnoses/d1/report") == b"<html>"
    assert lab.diagnoses.report("d1") == "<html>"
    assert lab.request("DELETE", "/v1/rigs/r1") is None


def test_files_go_as_multipart(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/measurements/import", {"id": "m1"})
    lab.request("POST", "/v1/measurements/import", files={"file": ("a.npz", b"PK")}, data={"rig_id": "r1"})
    sent = service.requests[0]
    assert sent.headers["content-type"].startswith("multipart/form-data")
    assert b'name="rig_id"' in sent.content
    assert b'filename="a.npz"' in sent.content


@pytest.mark.parametrize("code", sorted(errors.BY_CODE))
def test_every_kind_of_problem_has_its_class(lab: ModalLab, service: FakeService, code: str) -> None:
    service.on("GET /v1/rigs/r1", problem(422, code, "no such thing", field="node", value=99))
    with pytest.raises(errors.BY_CODE[code]) as caught:
        lab.rigs.get("r1")
    error = caught.value
    assert type(error) is errors.BY_CODE[code]
    assert (error.code, error.detail, error.status) == (code, "no such thing", 422)
    assert error.context == {"field": "node", "value": 99}
    assert "no such thing" in str(error)
    assert "99" in str(error)


def test_a_problem_of_a_later_service_is_still_a_client_error(lab: ModalLab, service: FakeService) -> None:
    service.on("GET /v1/rigs/r1", problem(418, "teapot", "short and stout"))
    with pytest.raises(ClientError) as caught:
        lab.rigs.get("r1")
    assert type(caught.value) is ClientError
    assert (caught.value.code, caught.value.detail) == ("teapot", "short and stout")


def test_a_refusal_that_is_no_problem_document_keeps_its_words(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/structures", httpx.Response(413, content=b"<h1>too big</h1>"))
    with pytest.raises(ClientError, match="too big") as caught:
        lab.structures.catalogue("bay")
    assert (caught.value.code, caught.value.status) == ("http_413", 413)


def test_a_reply_without_a_promised_field_says_which(lab: ModalLab, service: FakeService) -> None:
    incomplete = completed(results.Structure, {"id": "s1"})
    del incomplete["members"]
    service.on("POST /v1/structures", httpx.Response(201, json=incomplete))
    with pytest.raises(errors.UnexpectedReplyError, match="'members'"):
        lab.structures.catalogue("chapter-5-beam")


def test_a_get_is_asked_again_when_the_connection_breaks(lab: ModalLab, service: FakeService) -> None:
    def broken(request: httpx.Request) -> httpx.Response:
        raise httpx.ReadError("connection reset", request=request)

    service.on("GET /v1/rigs/r1", broken, httpx.Response(502), httpx.Response(200, json=RIG))
    assert lab.rigs.get("r1").id == "r1"
    assert service.asked("GET /v1/rigs/r1") == 3


def test_a_post_is_never_sent_twice_when_the_connection_breaks(lab: ModalLab, service: FakeService) -> None:
    def broken(request: httpx.Request) -> httpx.Response:
        raise httpx.ReadError("connection reset", request=request)

    service.on("POST /v1/rigs", broken)
    with pytest.raises(errors.UnreachableError, match="connection reset"):
        lab.rigs.create(drive="1:+Y", responses=["1:+Y"])
    service.on("POST /v1/rigs", httpx.Response(502))
    with pytest.raises(ClientError):
        lab.rigs.create(drive="1:+Y", responses=["1:+Y"])
    assert service.asked("POST /v1/rigs") == 2


@pytest.mark.parametrize(("status", "code"), [(503, "busy"), (429, "queue_quota")])
def test_a_full_queue_is_waited_for_as_long_as_it_says(
    lab: ModalLab, service: FakeService, status: int, code: str
) -> None:
    full = problem(status, code, "the queue is full")
    full.headers["retry-after"] = "0"
    service.on("POST /v1/rigs", full, full, httpx.Response(201, json=RIG))
    assert lab.rigs.create(drive="1:+Y", responses=["1:+Y"]).id == "r1"
    service.on("POST /v1/rigs", full)
    with pytest.raises(errors.BusyError):
        lab.rigs.create(drive="1:+Y", responses=["1:+Y"])
    full.headers["retry-after"] = "3600"
    sent = len(service.requests)
    with pytest.raises(errors.BusyError):
        lab.rigs.create(drive="1:+Y", responses=["1:+Y"])
    assert len(service.requests) == sent + 1, "an hour is for the caller to decide"


def test_a_date_to_come_back_is_left_to_the_caller(lab: ModalLab, service: FakeService) -> None:
    full = problem(503, "queue_full", "the queue is full")
    full.headers["retry-after"] = "Fri, 31 Dec 1999 23:59:59 GMT"  # clocks of two machines differ
    service.on("POST /v1/rigs", full)
    with pytest.raises(errors.BusyError):
        lab.rigs.create(drive="1:+Y", responses=["1:+Y"])
    assert len(service.requests) == 1


def test_json_that_is_none_is_refused(lab: ModalLab, service: FakeService) -> None:
    headers = {"content-type": "application/json"}
    service.on("GET /v1/version", httpx.Response(200, content=b"{half", headers=headers))
    with pytest.raises(errors.UnexpectedReplyError):
        lab.request("GET", "/v1/version")
    service.on("GET /v1/version", httpx.Response(500, content=b"{half", headers=headers))
    with pytest.raises(ClientError, match="half"):
        lab.request("GET", "/v1/version")


def test_the_asynchronous_client_says_the_same(service: FakeService) -> None:
    service.on("POST /v1/structures", {"id": "s1", "n_nodes": 21, "n_dofs": 42, "members": 20})
    service.on("GET /v1/structures/none", problem(404, "not_found", "nothing there"))

    async def talk() -> None:
        async with (
            httpx.AsyncClient(transport=httpx.MockTransport(service)) as http,
            AsyncModalLab("http://lab:8000", http=http) as lab,
        ):
            assert (await lab.structures.catalogue("chapter-5-beam")).members == 20
            with pytest.raises(errors.NotFoundError):
                await lab.structures.get("none")

    asyncio.run(talk())


def test_a_client_of_its_own_is_closed_and_a_given_one_is_not(service: FakeService) -> None:
    http = httpx.Client(transport=httpx.MockTransport(service))
    with ModalLab("http://lab", http=http):
        pass
    assert not http.is_closed
    http.close()
    with ModalLab("http://127.0.0.1:1") as lab, pytest.raises(errors.UnreachableError):
        lab.structures.catalogue("bay")


def test_a_key_of_the_environment_is_sent_unless_another_is_given(
    service: FakeService, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MODALLAB_KEY", "of the environment")
    service.on("GET /v1/rigs", {"items": []})
    with httpx.Client(transport=httpx.MockTransport(service)) as http:
        for key in (None, "given", ""):
            with ModalLab("http://lab", api_key=key, http=http) as lab:
                lab.request("GET", "/v1/rigs")
    sent = [request.headers.get("authorization") for request in service.requests]
    assert sent == ["Bearer of the environment", "Bearer given", None]
