"""Jobs over HTTP: the event stream, the queue's end."""

import json
from typing import Any

import pytest

from modallab.api.app import job_book
from modallab.jobs.runner import QueueFullError


@pytest.fixture(scope="module")
def job(service: Any, beam: str, rig: str) -> Any:
    body = {"structure_id": beam, "rig_id": rig, "route": "expected"}
    return service.post("/v1/measurements", body, status=202)


def test_a_job_shows_what_it_made(service: Any, job: Any) -> None:
    assert (job["state"], job["fraction"], job["error"]) == ("succeeded", 1.0, None)
    assert service.get(f"/v1/measurements/{job['result_id']}")["id"] == job["result_id"]


def test_the_stream_of_a_finished_job_is_its_last_state(service: Any, job: Any) -> None:
    reply = service.request("GET", f"/v1/jobs/{job['id']}/events")
    assert reply.headers["content-type"].startswith("text/event-stream")
    events = [json.loads(line.removeprefix("data: ")) for line in reply.text.split("\n\n") if line]
    assert events == [job]


def test_the_stream_follows_a_job_to_its_end(service: Any, settings: Any) -> None:
    book = job_book(settings)
    job = book.open("measure_and_store", {}, owner="local")
    told: list[str] = []
    get = service.app.state.jobs.get

    def went_on(job_id: str, *, owner: str) -> Any:
        steps = [
            lambda: book.start(job_id),
            lambda: book.progress(job_id, 0.5, "half"),
            lambda: book.succeed(job_id),
        ]
        if len(told) < len(steps):
            steps[len(told)]()
        told.append(job_id)
        return get(job_id, owner=owner)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(service.app.state.jobs, "get", went_on)
        text = service.request("GET", f"/v1/jobs/{job.id}/events").text
    events = [json.loads(line.removeprefix("data: ")) for line in text.split("\n\n") if line]
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
