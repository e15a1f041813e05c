"""Jobs over HTTP: the event stream, the queue's end."""

import json
from typing import Any

import pytest

from modallab.api.runners import job_book
from modallab.jobs.runner import QueueFullError


@pytest.fixture(scope="module")
def job(service: Any, beam: str, rig: str) -> Any:
    body = {"structure_id": beam, "rig_id": rig, "route": "expected"}
    return service.post("/v1/measurements", body, status=202)


def events_of(text: str) -> list[Any]:
    """Return what the events of a stream say."""
    return [
        json.loads(line.removeprefix("data: ")) for line in text.splitlines() if line.startswith("data: ")
    ]


def test_a_job_shows_what_it_made(service: Any, job: Any) -> None:
    assert (job["state"], job["fraction"], job["error"]) == ("succeeded", 1.0, None)
    assert service.get(f"/v1/measurements/{job['result_id']}")["id"] == job["result_id"]


def test_the_stream_of_a_finished_job_is_its_last_state(service: Any, job: Any) -> None:
    reply = service.request("GET", f"/v1/jobs/{job['id']}/events")
    assert reply.headers["content-type"].startswith("text/event-stream")
    events = events_of(reply.text)
    assert events == [job]


def test_the_stream_follows_a_job_to_its_end(service: Any, settings: Any) -> None:
    book = job_book(settings)
    job = book.open("measure_and_store", {}, owner="local")
    told: list[str] = []
    get = service.app.state.jobs.get

    def went_on(job_id: str, *, viewer: Any) -> Any:
        steps = [
            lambda: book.start(job_id),
            lambda: book.progress(job_id, 0.5, "half"),
            lambda: book.succeed(job_id),
        ]
        if len(told) < len(steps):
            steps[len(told)]()
        told.append(job_id)
        return get(job_id, viewer=viewer)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(service.app.state.jobs, "get", went_on)
        text = service.request("GET", f"/v1/jobs/{job.id}/events").text
    events = events_of(text)
    assert [event["state"] for event in events] == ["running", "running", "succeeded"]
    assert events[1]["message"] == "half"


def test_cancelling_what_has_ended_changes_nothing(service: Any, job: Any) -> None:
    assert service.request("DELETE", f"/v1/jobs/{job['id']}").json() == job


def test_a_full_queue_is_a_503_that_says_when_to_come_again(
    service: Any, beam: str, rig: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_given: object, **_more: object) -> None:
        raise QueueFullError("as many jobs wait as may", allowed=1)

    monkeypatch.setattr(service.app.state.jobs, "submit", full)
    reply = service.request("POST", "/v1/measurements", json={"structure_id": beam, "rig_id": rig})
    assert (reply.status_code, reply.json()["code"]) == (503, "queue_full")
    assert int(reply.headers["retry-after"]) >= 1


def test_a_stream_that_goes_on_does_not_repeat_its_last_event(service: Any, settings: Any) -> None:
    book = job_book(settings)
    job = book.open("measure_and_store", {}, owner="local")
    path = f"/v1/jobs/{job.id}/events"
    get = service.app.state.jobs.get
    calls: list[str] = []

    def ends(job_id: str, *, viewer: Any) -> Any:
        calls.append(job_id)
        if len(calls) % 3 == 0:
            book.succeed(job_id)
        return get(job_id, viewer=viewer)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(service.app.state.jobs, "get", ends)
        first = service.request("GET", path).text.splitlines()[0]
        assert first.startswith("id: ")
        ended = service.request("GET", path, headers={"Last-Event-ID": first.removeprefix("id: ")}).text
    assert [event["state"] for event in events_of(ended)] == ["succeeded"]


def test_jobs_are_listed_newest_first_by_state_and_kind(service: Any, settings: Any) -> None:
    book = job_book(settings)
    older = book.open("update_and_store", {}, owner="local")
    newer = book.open("update_and_store", {}, owner="local")
    book.open("update_and_store", {}, owner="another")
    listed = service.get("/v1/jobs?state=queued&kind=update")
    assert [job["id"] for job in listed["items"]] == [newer.id, older.id]
    assert [job["place"] for job in listed["items"]] == [3, 2]  # the owner who is new has the first turn
    assert listed["next"] is None
    page = service.get("/v1/jobs?state=queued&kind=update&limit=1")
    assert [job["id"] for job in page["items"]] == [newer.id] == [page["next"]]
    rest = service.get(f"/v1/jobs?state=queued&kind=update&limit=1&after={page['next']}")
    assert [job["id"] for job in rest["items"]] == [older.id]
    assert service.get("/v1/jobs?state=queued&kind=study")["items"] == []
    reply = service.request("GET", "/v1/jobs?kind=holiday")
    assert reply.status_code == 422
    assert set(service.request("DELETE", "/v1/jobs?kind=update").json()["cancelled"]) == {older.id, newer.id}
    states = [job["state"] for job in service.get("/v1/jobs?kind=update")["items"]]
    assert states == ["cancelled", "cancelled"]


def test_a_request_that_is_repeated_with_its_key_starts_one_job(service: Any, beam: str, rig: str) -> None:
    body = {"structure_id": beam, "rig_id": rig, "route": "expected"}
    once, again = (
        service.request("POST", "/v1/measurements", json=body, headers={"Idempotency-Key": "mine-1"})
        for _ in range(2)
    )
    assert once.status_code == again.status_code == 202
    assert once.json() == again.json()
    other = service.request(
        "POST", "/v1/measurements", json=body | {"seed": 7}, headers={"Idempotency-Key": "mine-1"}
    )
    assert (other.status_code, other.json()["code"]) == (409, "key_reused")
    assert other.json()["context"]["value"] == "mine-1"


def test_a_job_says_when_it_began_and_ended(job: Any) -> None:
    assert job["created"] <= job["started"] <= job["ended"]
    assert job["message"] == "finished"
    assert job["place"] is None


def test_a_stream_looks_seldom_at_a_job_that_is_far_from_the_front(service: Any, settings: Any) -> None:
    book = job_book(settings)
    ahead = [book.open("measure_and_store", {}, owner="many").id for _ in range(30)]
    job = book.open("measure_and_store", {}, owner="many")
    assert job.place is not None
    pauses: list[float] = []

    async def pause(seconds: float) -> None:
        pauses.append(seconds)
        for job_id in ahead[: -2 if len(pauses) == 1 else None]:
            book.cancel(job_id)
        if len(pauses) == 3:
            book.cancel(job.id)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("modallab.api.jobs.sleep", pause)
        service.request("GET", f"/v1/jobs/{job.id}/events")
    left = job.place - 28
    assert pauses == pytest.approx([1.0, min(0.1 * left, 1.0), 0.1 * (left - 2)])
