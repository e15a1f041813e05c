"""Long work on the service: wait for it, follow it, cancel it."""

import math
import time
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from modallab_client import _wire
from modallab_client._generated.models import CancelledJobs, JobPage
from modallab_client._progress import progress_bar
from modallab_client._sync.pages import all_items
from modallab_client._sync.transport import Transport
from modallab_client._waiting import closing, sleep
from modallab_client.errors import JobTimeoutError, UnexpectedReplyError, UnreachableError
from modallab_client.results import JobStatus
from modallab_client.settings import CONNECTION

T = TypeVar("T")

OnProgress = Callable[[float, str], object]


class Jobs:
    """All the work on the service, of whatever kind."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport

    def get(self, job_id: str) -> JobStatus:
        """Return where a job stands."""
        return _wire.reply(JobStatus, self._transport.request("GET", f"/v1/jobs/{job_id}"))

    def list(self, *, state: str | None = None, kind: str | None = None) -> tuple[JobStatus, ...]:
        """Return jobs, newest first.

        Parameters
        ----------
        state
            `queued`, `running`, `succeeded`, `failed` or `cancelled`; None: any.
        kind
            What they make: `measurement`, `modal_model`, `update`, `diagnosis` or `study`; None: anything.
        """
        return all_items(self._transport, "/v1/jobs", JobPage, state=state, kind=kind)

    def cancel(self, job_id: str) -> None:
        """Ask a job to stop."""
        self._transport.request("DELETE", f"/v1/jobs/{job_id}")

    def cancel_all(self, *, kind: str | None = None) -> tuple[str, ...]:
        """Ask all waiting and running jobs to stop, and return their ids.

        Parameters
        ----------
        kind
            What the jobs make, as in `list`; None: anything.
        """
        reply = self._transport.request("DELETE", "/v1/jobs", params=_wire.body(kind=kind))
        return tuple(_wire.reply(CancelledJobs, reply).cancelled)


@dataclass(frozen=True)
class Job(Generic[T]):
    """Work under way on the service; `result` waits for it."""

    id: str
    _transport: Transport = field(repr=False)
    _fetch: Callable[[str], T] = field(repr=False)

    def status(self) -> JobStatus:
        """Return where the job stands."""
        return Jobs(self._transport).get(self.id)

    def cancel(self) -> None:
        """Ask the job to stop; `result` then raises `JobFailedError` with code `cancelled`."""
        Jobs(self._transport).cancel(self.id)

    def result(
        self,
        on_progress: OnProgress | None = None,
        timeout: float | None = None,
        *,
        progress: bool = False,
    ) -> T:
        """Wait, report progress, and return the finished thing.

        Parameters
        ----------
        on_progress
            Called with the fraction done, 0 to 1 in thousandths, and a message, whenever one of them changes.
        timeout
            Longest wait in s; the job goes on after it.
        progress
            Show a bar by tqdm, in a notebook or a terminal; where tqdm is not installed, a line a tenth.

        Raises
        ------
        JobFailedError
            If the work failed or was cancelled, with the service's own code, detail and context.
        JobTimeoutError
            If the time is over.
        """
        with progress_bar(wanted=progress) as bar:
            return self._followed([watch for watch in (on_progress, bar) if watch is not None], timeout)

    def _followed(self, watchers: Sequence[OnProgress], timeout: float | None) -> T:
        """Return the finished thing; tell the watchers of every change until then."""
        deadline = math.inf if timeout is None else time.monotonic() + timeout
        reported: tuple[float, str] | None = None
        with closing(self._statuses(deadline)) as statuses:
            for status in statuses:
                news = (round(status.fraction, 3), status.message)
                if news != reported:
                    for watch in watchers:
                        watch(*news)
                reported = news
                if status.finished:
                    return self._outcome(status)
                if time.monotonic() >= deadline:
                    break
        raise JobTimeoutError(f"job {self.id} is not finished after {timeout:g} s", context={"job": self.id})

    def _statuses(self, deadline: float) -> Generator[JobStatus]:
        """Yield the job's states: from the event stream, and by asking wherever that breaks."""
        last_event, breaks = time.monotonic(), 0
        while True:
            patience = max(0.01, min(CONNECTION.event_timeout, deadline - time.monotonic()))
            events = self._transport.events(f"/v1/jobs/{self.id}/events", patience=patience)
            with closing(events) as stream:
                for event in stream:
                    last_event = time.monotonic()
                    if "state" in event:  # and not a mere sign of life
                        yield _wire.reply(JobStatus, {"id": self.id, **event})
            try:
                yield self.status()
                last_event = time.monotonic()
            except UnreachableError:
                if time.monotonic() > min(last_event + CONNECTION.outage, deadline):
                    raise
            sleep(CONNECTION.polling[min(breaks, len(CONNECTION.polling) - 1)])
            breaks += 1

    def _outcome(self, status: JobStatus) -> T:
        if status.state != "succeeded":
            raise _wire.job_failure(status)
        if status.result_id is None:
            raise UnexpectedReplyError(f"job {self.id} succeeded without a result")
        return self._fetch(status.result_id)
