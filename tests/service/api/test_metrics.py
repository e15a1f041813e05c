"""What Prometheus reads of the service, and what its log says of requests and jobs."""

from typing import Any

import pytest
import structlog
from prometheus_client.parser import text_string_to_metric_families
from structlog.testing import capture_logs

from modallab.api import logs


def scraped(service: Any) -> dict[tuple[str, tuple[str, ...]], float]:
    """Return the value of every sample by its name and its labels' values."""
    reply = service.request("GET", "/metrics")
    assert reply.status_code == 200
    assert reply.headers["content-type"].startswith("text/plain")
    return {
        (
            sample.name,
            tuple(value for name, value in sample.labels.items() if name != "le")
            + tuple(value for name, value in sample.labels.items() if name == "le"),
        ): sample.value
        for family in text_string_to_metric_families(reply.text)
        for sample in family.samples
    }


def test_requests_are_counted_by_route_not_by_id(service: Any, beam: str) -> None:
    counted = ("modallab_requests_total", ("GET", "/v1/structures/{id}", "200"))
    before = scraped(service).get(counted, 0.0)
    service.get(f"/v1/structures/{beam}")
    service.request("GET", "/v1/structures/none")
    service.request("GET", "/nowhere")
    after = scraped(service)
    assert after[counted] == before + 1
    assert after["modallab_requests_total", ("GET", "/v1/structures/{id}", "404")] >= 1
    assert after["modallab_requests_total", ("GET", "none", "404")] >= 1
    assert after["modallab_request_seconds_count", ("GET", "/v1/structures/{id}")] >= 2


def test_jobs_are_counted_and_timed(service: Any, beam: str, rig: str) -> None:
    body = {"structure_id": beam, "rig_id": rig, "route": "expected", "seed": 1}
    ended = ("modallab_jobs_ended_total", ("succeeded", "measure_and_store"))
    before = scraped(service).get(ended, 0.0)
    job = service.get(f"/v1/jobs/{service.post('/v1/measurements', body, status=202)['id']}")
    after = scraped(service)
    assert after[ended] == before + 1
    assert after["modallab_job_run_seconds_count", ("measure_and_store",)] == before + 1
    assert after["modallab_job_run_seconds_bucket", ("measure_and_store", "+Inf")] == before + 1
    assert job["ended"] > job["started"]
    seconds = after["modallab_job_run_seconds_sum", ("measure_and_store",)]
    assert 0 < seconds < 60  # a test by the expected route takes some ms
    assert after["modallab_workers", ()] == 0  # the jobs of this service run where they are asked for


@pytest.fixture
def unbound(monkeypatch: pytest.MonkeyPatch) -> None:
    """A logger that `capture_logs` reaches: others may have bound it before."""
    monkeypatch.setattr(logs, "_log", structlog.get_logger())


@pytest.mark.usefixtures("unbound")
def test_a_request_is_a_line_of_the_log_with_its_id(service: Any, beam: str) -> None:
    with capture_logs([structlog.contextvars.merge_contextvars]) as lines:
        service.request("GET", f"/v1/structures/{beam}", headers={"X-Request-Id": "mine"})
    (line,) = (line for line in lines if line["event"] == "request")
    assert line.pop("seconds") >= 0
    assert line == {
        "event": "request",
        "log_level": "info",
        "request": "mine",
        "method": "GET",
        "path": f"/v1/structures/{beam}",
        "status": 200,
    }
