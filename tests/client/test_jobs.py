"""Waiting for work on the service."""

import asyncio
from dataclasses import replace
from typing import Any

import httpx
import pytest

from modallab_client import AsyncModalLab, Job, JobFailedError, JobTimeoutError, ModalLab, errors
from modallab_client._sync import jobs
from modallab_client.results import JobStatus, Measurement
from modallab_client.settings import CONNECTION
from tests.client.fake import MEASUREMENT, FakeService, completed, events, npz, problem


def state(name: str, fraction: float = 0.0, message: str = "", **more: Any) -> dict[str, Any]:
    given = {"id": "j1", "state": name, "fraction": fraction, "message": message, **more}
    return completed(JobStatus, given)


DONE = state("succeeded", 1.0, "done", result_id="m1", error=None)


@pytest.fixture
def job(lab: ModalLab, service: FakeService) -> Job[Measurement]:
    service.on("POST /v1/measurements", httpx.Response(202, json=state("queued")))
    service.on("GET /v1/measurements/m1", {"id": "m1", "rig_id": "r1"})
    service.on("GET /v1/measurements/m1/arrays", npz(**MEASUREMENT))
    return lab.measurements.start("s1", "r1", seed=4)


def test_progress_is_told_once_a_change_and_the_thing_comes_back(
    job: Job[Measurement], service: FakeService
) -> None:
    half = state("running", 0.5, "block 50 of 100")
    service.on("GET /v1/jobs/j1/events", events(state("queued"), half, half, DONE))
    told: list[tuple[float, str]] = []
    test = job.result(on_progress=lambda fraction, message: told.append((fraction, message)))
    assert test.id == "m1"
    assert told == [(0.0, ""), (0.5, "block 50 of 100"), (1.0, "done")]


def test_print_will_do_for_progress(
    job: Job[Measurement], service: FakeService, capsys: pytest.CaptureFixture[str]
) -> None:
    service.on("GET /v1/jobs/j1/events", events(DONE))
    job.result(on_progress=print)
    assert capsys.readouterr().out == "1.0 done\n"


def test_a_stream_that_breaks_is_taken_up_again(job: Job[Measurement], service: FakeService) -> None:
    service.on("GET /v1/jobs/j1/events", events(state("running", 0.2)), broken, events({}), events(DONE))
    service.on("GET /v1/jobs/j1", state("running", 0.3))
    assert job.result().id == "m1"
    assert service.asked("GET /v1/jobs/j1/events") == 4


def broken(request: httpx.Request) -> httpx.Response:
    raise httpx.ConnectError("connection refused", request=request)


def test_a_service_that_restarts_is_waited_for(job: Job[Measurement], service: FakeService) -> None:
    service.on("GET /v1/jobs/j1/events", broken, events(DONE))
    service.on("GET /v1/jobs/j1", broken)
    assert job.result().id == "m1"


def test_a_service_that_stays_away_is_not(
    job: Job[Measurement], service: FakeService, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jobs, "CONNECTION", replace(CONNECTION, outage=0.0))
    service.on("GET /v1/jobs/j1/events", broken)
    service.on("GET /v1/jobs/j1", broken)
    with pytest.raises(errors.UnreachableError, match="connection refused"):
        job.result()


def test_without_a_stream_the_job_is_asked_until_it_is_done(
    job: Job[Measurement], service: FakeService
) -> None:
    service.on("GET /v1/jobs/j1/events", httpx.Response(200, json={"no": "stream"}))
    service.on("GET /v1/jobs/j1", state("running", 0.3), DONE)
    assert job.result().id == "m1"


def test_a_failed_job_speaks_in_the_words_of_the_service(job: Job[Measurement], service: FakeService) -> None:
    error = {"code": "diverged", "detail": "no way back", "context": {"iteration": 3}, "status": 422}
    service.on("GET /v1/jobs/j1/events", events(state("failed", 0.4, error=error)))
    with pytest.raises(JobFailedError, match="no way back") as caught:
        job.result()
    assert caught.value.code == "diverged"
    assert caught.value.context == {"iteration": 3}


def test_a_cancelled_job_says_so(job: Job[Measurement], service: FakeService) -> None:
    service.on("DELETE /v1/jobs/j1", httpx.Response(202, json=state("running")))
    service.on("GET /v1/jobs/j1/events", events(state("cancelled", 0.4, error=None)))
    job.cancel()
    with pytest.raises(JobFailedError) as caught:
        job.result()
    assert caught.value.code == "cancelled"
    assert service.asked("DELETE /v1/jobs/j1") == 1


def test_a_wait_that_is_too_long_ends_and_the_job_does_not(
    job: Job[Measurement], service: FakeService
) -> None:
    service.on("GET /v1/jobs/j1/events", events(state("running", 0.2)))
    service.on("GET /v1/jobs/j1", state("running", 0.2))
    with pytest.raises(JobTimeoutError, match="j1"):
        job.result(timeout=0.05)
    assert service.asked("DELETE /v1/jobs/j1") == 0
    assert job.status().state == "running"


def test_an_unknown_job_is_not_waited_for(job: Job[Measurement], service: FakeService) -> None:
    service.on("GET /v1/jobs/j1/events", problem(404, "not_found", "no such job"))
    with pytest.raises(LookupError, match="no such job"):
        job.result()


def test_an_asynchronous_job_does_the_same(service: FakeService) -> None:
    service.on("POST /v1/measurements", httpx.Response(202, json=state("queued")))
    service.on("GET /v1/jobs/j1/events", events(state("running", 0.5)), events(DONE))
    service.on("GET /v1/jobs/j1", state("running", 0.5))
    service.on("GET /v1/measurements/m1", {"id": "m1"})
    service.on("GET /v1/measurements/m1/arrays", npz(**MEASUREMENT))

    async def measure() -> Measurement:
        async with httpx.AsyncClient(transport=httpx.MockTransport(service)) as http:
            lab = AsyncModalLab("http://lab", http=http)
            return await (await lab.measurements.start("s1", "r1")).result(timeout=60)

    assert asyncio.run(measure()).id == "m1"


def test_jobs_are_listed_over_all_pages_and_cancelled_together(lab: ModalLab, service: FakeService) -> None:
    pages: list[dict[str, Any]] = [
        {"items": [state("running")], "next": "j1"},
        {"items": [DONE], "next": None},
    ]
    service.on("GET /v1/jobs", *pages)
    service.on("DELETE /v1/jobs", {"cancelled": ["j1"]})
    assert [job.state for job in lab.jobs.list(kind="measurement")] == ["running", "succeeded"]
    assert service.asked("GET /v1/jobs") == 2
    assert lab.jobs.cancel_all() == ("j1",)
