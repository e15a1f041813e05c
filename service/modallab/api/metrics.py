"""Measures of the service for Prometheus: its requests, and the jobs of all processes."""

import time
from collections.abc import Iterator

from prometheus_client import CollectorRegistry, Counter, Histogram, ProcessCollector, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, HistogramMetricFamily, Metric
from prometheus_client.registry import Collector
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from modallab.jobs.executors import ExecutorBook
from modallab.jobs.runner import JobState
from modallab.jobs.statistics import Times, job_statistics
from modallab.store.place import StorePlace, engine_of

_MEDIA_TYPE = "text/plain; version=0.0.4; charset=utf-8"
_REQUEST_SECONDS = (0.005, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
_JOB_SECONDS = (0.1, 0.5, 1.0, 5.0, 15.0, 60.0, 300.0, 1800.0, 7200.0)
_ACTIVE = (JobState.QUEUED.value, JobState.RUNNING.value)


class Metrics:
    """Counters of this process, and a look into the book of jobs at each scrape."""

    def __init__(self, place: StorePlace) -> None:
        self.registry = CollectorRegistry()
        self.requests = Counter(
            "modallab_requests", "Requests answered", ("method", "route", "status"), registry=self.registry
        )
        self.seconds = Histogram(
            "modallab_request_seconds",
            "Time until a request is answered",
            ("method", "route"),
            buckets=_REQUEST_SECONDS,
            registry=self.registry,
        )
        self.registry.register(_Jobs(place))
        ProcessCollector(registry=self.registry)

    def reply(self) -> Response:
        """Return all measures in Prometheus' text format."""
        return Response(generate_latest(self.registry), media_type=_MEDIA_TYPE)


class _Jobs(Collector):
    def __init__(self, place: StorePlace) -> None:
        self._place = place

    def describe(self) -> list[Metric]:
        """Return nothing: the database is not asked before a scrape."""
        return []

    def collect(self) -> Iterator[Metric]:
        """Yield what the database says of jobs and workers."""
        engine = engine_of(self._place)
        statistics = job_statistics(engine, _JOB_SECONDS)
        active = GaugeMetricFamily("modallab_jobs_active", "Jobs that wait or run", labels=("task", "state"))
        ended = CounterMetricFamily("modallab_jobs_ended", "Jobs that have ended", labels=("task", "state"))
        for (task, state), n in sorted(statistics.counts.items()):
            (active if state in _ACTIVE else ended).add_metric((task, state), n)
        yield from (active, ended)
        yield _histogram("modallab_job_wait_seconds", "Time until the work begins", statistics.waits)
        yield _histogram("modallab_job_run_seconds", "Time from begin to end of the work", statistics.runs)
        workers = GaugeMetricFamily("modallab_workers", "Processes that run jobs")
        workers.add_metric((), len(ExecutorBook(engine).all()))
        yield workers


def _histogram(name: str, doc: str, times: dict[str, Times]) -> HistogramMetricFamily:
    family = HistogramMetricFamily(name, doc, labels=("task",))
    for task, distribution in sorted(times.items()):
        buckets = [
            (str(bound), float(n)) for bound, n in zip(_JOB_SECONDS, distribution.buckets, strict=True)
        ]
        family.add_metric((task,), [*buckets, ("+Inf", float(distribution.count))], distribution.total)
    return family


class Measured:
    """Counts and times the requests of an application."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self._app, self._metrics = app, metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle an ASGI request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        begin, status = time.monotonic(), 500

        async def send_noted(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                self._metrics.seconds.labels(scope["method"], route_of(scope)).observe(
                    time.monotonic() - begin
                )
            await send(message)

        try:
            await self._app(scope, receive, send_noted)
        finally:
            self._metrics.requests.labels(scope["method"], route_of(scope), str(status)).inc()


def route_of(scope: Scope) -> str:
    """Return the path of the route that a request matched, without the ids in it."""
    parameters = scope.get("path_params") or {}
    if "route" not in scope:
        return "none"
    path = str(scope["path"])
    for name, value in parameters.items():
        path = path.replace(f"/{value}", f"/{{{name}}}", 1)
    return path
