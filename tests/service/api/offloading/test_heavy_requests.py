"""Heavy requests: answered by another process as by this one, few at once, within limits."""

import asyncio
import os
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fastapi import APIRouter

from modallab.api.offloading import confinement, processes, route
from modallab.api.offloading.processes import RequestProcesses
from modallab.api.offloading.settings import OFFLOADING
from modallab.api.offloading.worker import answer, prepare

STEEL = {"modulus": 2.09e11, "density": 7800.0}
PLATE = {"kind": "plate", "length": 0.6, "width": 0.4, "thickness": 0.004, "material": STEEL}
HEAVY = PLATE | {"n_elements": [16, 16]}


@pytest.fixture(scope="module")
def plate(offloading: Any) -> str:
    """Id of a plate that is heavy."""
    return str(offloading.post("/v1/structures", HEAVY)["id"])


class Counted:
    """Counts the requests that go to worker processes."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.n = 0
        answer = RequestProcesses._answered

        async def counted(*given: Any) -> Any:
            self.n += 1
            return await answer(*given)

        monkeypatch.setattr(RequestProcesses, "_answered", counted)


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Counted:
    return Counted(monkeypatch)


@pytest.mark.parametrize(
    "path", ["", "/modes?count=3", "/modes/arrays?count=3", "/geometry.uff", "/modes?count=0"]
)
def test_another_process_answers_as_this_one(
    service: Any, offloading: Any, plate: str, counted: Counted, path: str
) -> None:
    here, there = (s.request("GET", f"/v1/structures/{plate}{path}") for s in (service, offloading))
    assert (there.status_code, there.content) == (here.status_code, here.content)
    assert counted.n == 1
    told = [{name: r.headers[name] for name in r.headers if name != "x-request-id"} for r in (here, there)]
    assert told[0] == told[1]


def test_a_reply_keeps_the_id_of_its_request(offloading: Any, plate: str) -> None:
    reply = offloading.request("GET", f"/v1/structures/{plate}", headers={"X-Request-Id": "mine"})
    assert reply.headers["x-request-id"] == "mine"


def test_light_requests_stay_in_this_process(offloading: Any, counted: Counted) -> None:
    beam = offloading.post("/v1/structures", {"kind": "catalogue", "name": "chapter-5-beam"})["id"]
    small = offloading.post("/v1/structures", PLATE | {"n_elements": [4, 4]})["id"]
    offloading.get(f"/v1/structures/{beam}/modes?count=100")
    offloading.get(f"/v1/structures/{small}/modes")
    offloading.get("/v1/structures")
    assert offloading.request("GET", "/v1/structures/nothing").status_code == 404
    assert (
        offloading.request(
            "POST", "/v1/structures", content=b"{", headers={"Content-Type": "application/json"}
        ).status_code
        == 422
    )
    assert counted.n == 0


def test_files_are_read_in_another_process(offloading: Any, counted: Counted) -> None:
    reply = offloading.request("POST", "/v1/structures/import", files={"file": ("a", b"nothing")})
    assert (reply.status_code, reply.json()["context"]["field"]) == (422, "file")
    assert counted.n == 1


def test_what_a_correlation_compares_counts(offloading: Any, plate: str, counted: Counted) -> None:
    synthetic = {"count": 3, "dofs": ["20:+Z", "100:+Z", "150:+Z"]}
    modes = offloading.post(f"/v1/structures/{plate}/synthetic-modes", synthetic)["id"]
    found = offloading.post("/v1/correlations", {"structure_id": plate, "modal_model_id": modes})
    assert np.diag(np.array(found["mac"], float)[:3, :3]) == pytest.approx(np.ones(3))  # the very same modes
    assert counted.n == 2


def test_a_reply_of_many_bytes_comes_whole(
    service: Any, offloading: Any, plate: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = service.request("GET", f"/v1/structures/{plate}/modes/arrays?count=100").content
    assert offloading.request("GET", f"/v1/structures/{plate}/modes/arrays?count=100").content == here
    assert len(here) < OFFLOADING.chunk_bytes  # that came as a value; as a file:
    monkeypatch.setattr(
        "modallab.api.offloading.forwarding.OFFLOADING", replace(OFFLOADING, chunk_bytes=1000)
    )
    assert offloading.request("GET", f"/v1/structures/{plate}/modes/arrays?count=100").content == here


def test_the_same_request_at_once_is_answered_once(offloading: Any, plate: str, counted: Counted) -> None:
    async def at_once() -> list[Any]:
        import httpx

        transport = httpx.ASGITransport(offloading.app)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            return await asyncio.gather(
                *(client.get(f"/v1/structures/{plate}/modes?count=9") for _ in range(20))
            )

    replies = offloading._portal.call(at_once)
    assert {reply.status_code for reply in replies} == {200}
    assert len({reply.content for reply in replies}) == 1
    assert counted.n == 1


def test_who_finds_no_process_free_comes_again(
    offloading: Any, plate: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(processes, "OFFLOADING", replace(OFFLOADING, waiting_seconds=0.05))
    free = offloading.app.state.processes._free
    offloading._portal.call(free.acquire)
    try:
        reply = offloading.request("GET", f"/v1/structures/{plate}/modes")
    finally:
        offloading._portal.call(free.release)
    assert (reply.status_code, reply.json()["code"]) == (503, "busy")
    assert int(reply.headers["retry-after"]) >= 1


def test_who_waits_too_long_on_a_busy_machine_comes_again(
    offloading: Any, plate: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(processes, "OFFLOADING", replace(OFFLOADING, seconds=0.01))
        reply = offloading.request("GET", f"/v1/structures/{plate}/modes")
    assert (reply.status_code, reply.json()["code"]) == (503, "busy")
    assert offloading.request("GET", f"/v1/structures/{plate}/modes").status_code == 200


def test_a_process_that_starts_slowly_delays_no_answer_and_serves_the_next(
    offloading: Any, plate: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A start, a wait and an answer had a time each: 17.7 s of 10 on a machine with other work."""
    run, started, slow = offloading.app.state.processes._processes.run, [], asyncio.Event()

    async def run_slowly(work: Any, *given: Any) -> Any:
        if work is prepare:
            await slow.wait()
            started.append(work)
        return await run(work, *given)

    monkeypatch.setattr(offloading.app.state.processes._processes, "run", run_slowly)
    with monkeypatch.context() as patch:
        patch.setattr(processes, "OFFLOADING", replace(OFFLOADING, seconds=0.05))
        reply = offloading.request("GET", f"/v1/structures/{plate}/modes")
    assert (reply.status_code, reply.json()["code"], started) == (503, "busy", [])
    offloading._portal.call(slow.set)
    assert offloading.request("GET", f"/v1/structures/{plate}/modes").status_code == 200
    assert len(started) == 2  # that of the first request went on


@pytest.mark.parametrize("limit", [confinement.OUT_OF_TIME, confinement.OUT_OF_MEMORY])
def test_what_takes_too_much_is_refused_and_not_tried_twice(
    offloading: Any, plate: str, monkeypatch: pytest.MonkeyPatch, limit: str
) -> None:
    """Twice the modes of a large plate took 12 s, of 10 in which all are answered."""
    run, asked = offloading.app.state.processes._processes.run, 0

    async def run_and_end(work: Any, *given: Any) -> Any:
        nonlocal asked
        if work is not answer:
            return await run(work, *given)
        asked += 1
        return await run(confinement.end_process, given[1].folder, limit)

    monkeypatch.setattr(offloading.app.state.processes._processes, "run", run_and_end)
    reply = offloading.request("GET", f"/v1/structures/{plate}/modes")
    assert (reply.status_code, reply.json()["code"]) == (422, "too_costly")
    assert reply.json()["context"]["field"] == "id"
    assert limit in reply.json()["detail"]
    assert asked == 1


@pytest.mark.parametrize(("method", "status"), [("GET", 200), ("POST", 422)])
def test_a_process_that_was_killed_is_asked_again_for_what_it_read(
    offloading: Any, plate: str, monkeypatch: pytest.MonkeyPatch, method: str, status: int
) -> None:
    run, asked = offloading.app.state.processes._processes.run, 0

    async def run_and_end_once(work: Any, *given: Any) -> Any:
        nonlocal asked
        asked += work is answer
        return await (run(os._exit, 1) if work is answer and asked == 1 else run(work, *given))

    monkeypatch.setattr(offloading.app.state.processes._processes, "run", run_and_end_once)
    path, body = f"/v1/structures/{plate}/modes", None
    if method == "POST":  # once more, it might leave two
        path, body = "/v1/structures", HEAVY
    assert offloading.request(method, path, json=body).status_code == status
    assert asked == (2 if method == "GET" else 1)


def test_stored_arrays_are_sent_by_this_process(offloading: Any, plate: str, counted: Counted) -> None:
    synthetic = {"count": 3, "dofs": ["20:+Z", "100:+Z", "150:+Z"]}
    modes = offloading.post(f"/v1/structures/{plate}/synthetic-modes", synthetic)["id"]
    assert counted.n == 1
    assert offloading.request("GET", f"/v1/modal-models/{modes}/arrays").status_code == 200
    assert offloading.request("GET", f"/v1/modal-models/{modes}").status_code == 200
    assert counted.n == 1


def _routers(router: APIRouter) -> Iterator[APIRouter]:
    """Yield a router and those that it includes."""
    yield router
    for part in router.routes:
        if hasattr(part, "original_router"):
            yield from _routers(part.original_router)


def test_every_route_about_stored_things_weighs_its_requests(service: Any) -> None:
    paths = service.get("/openapi.json")["paths"]
    shelves = {path.split("/")[2] for path in paths} - {
        "jobs",
        "catalog",
        "health",
        "ready",
        "version",
        "limits",
        "keys",
        "classes",
        "assignments",
        "sessions",
        "trash",  # of rows alone: it reads no stored thing
    }
    routers = list(_routers(service.app.router))
    plain = {
        name
        for router in routers
        for name in shelves
        if router.prefix == f"/{name}" and not all(isinstance(r, route.OffloadedRoute) for r in router.routes)
    }
    assert not plain
    assert {f"/{name}" for name in shelves} <= {router.prefix for router in routers}
