"""Long work on the service: wait for it, follow it, cancel it."""

import math
import time
from collections.abc import AsyncGenerator, Awaitable, Callable, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from modallab_client import _wire
from modallab_client._async.pages import all_items
from modallab_client._async.transport import AsyncTransport
from modallab_client._generated.models import CancelledJobs, JobPage
from modallab_client._progress import progress_bar
from modallab_client._waiting import async_closing, async_sleep
from modallab_client.errors import JobTimeoutError, UnexpectedReplyError, UnreachableError
from modallab_client.results import JobStatus
from modallab_client.settings import CONNECTION

T = TypeVar("T")

OnProgress = Callable[[float, str], object]


class AsyncJobs:
    """All the work on the service, of whatever kind."""

    def __init__(self, transport: AsyncTransport) -> None:
        self._transport = transport

    async def get(self, job_id: str) -> JobStatus:
        """Return where a job stands."""
        return _wire.reply(JobStatus, await self._transport.request("GET", f"/v1/jobs/{job_id}"))

    async def list(self, *, state: str | None = None, kind: str | None = None) -> tuple[JobStatus, ...]:
        """Return jobs, newest first.

        Parameters
        ----------
        state
            `queued`, `running`, `succeeded`, `failed` or `cancelled`; None: any.
        kind
            What they make: `measurement`, `modal_model`, `update`, `diagnosis` or `study`; None: anything.
        """
        return await all_items(self._transport, "/v1/jobs", JobPage, state=state, kind=kind)

    async def cancel(self, job_id: str) -> None:
        """Ask a job to stop."""
        await self._transport.request("DELETE", f"/v1/jobs/{job_id}")

    async def cancel_all(self, *, kind: str | None = None) -> tuple[str, ...]:
        """Ask all waiting and running jobs to stop, and return their ids.

        Parameters
        ----------
        kind
            What the jobs make, as in `list`; None: anything.
        """
        reply = await self._transport.request("DELETE", "/v1/jobs", params=_wire.body(kind=kind))
        return tuple(_wire.reply(CancelledJobs, reply).cancelled)


@dataclass(frozen=True)
class AsyncJob(Generic[T]):
    """Work under way on the service; `result` waits for it."""

    id: str
    _transport: AsyncTransport = field(repr=False)
    _fetch: Callable[[str], Awaitable[T]] = field(repr=False)

    async def status(self) -> JobStatus:
        """Return where the job stands."""
        return await AsyncJobs(self._transport).get(self.id)

    async def cancel(self) -> None:
        """Ask the job to stop; `result` then raises `JobFailedError` with code `cancelled`."""
        await AsyncJobs(self._transport).cancel(self.id)

    async def result(
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
            return await self._followed([watch for watch in (on_progress, bar) if watch is not None], timeout)

    async def _followed(self, watchers: Sequence[OnProgress], timeout: float | None) -> T:
        """Return the finished thing; tell the watchers of every change until then."""
        deadline = math.inf if timeout is None else time.monotonic() + timeout
        reported: tuple[float, str] | None = None
        async with async_closing(self._statuses(deadline)) as statuses:
            async for status in statuses:
                news = (round(status.fraction, 3), status.message)
                if news != reported:
                    for watch in watchers:
                        watch(*news)
                reported = news
                if status.finished:
                    return await self._outcome(status)
                if time.monotonic() >= deadline:
                    break
        raise JobTimeoutError(f"job {self.id} is not finished after {timeout:g} s", context={"job": self.id})

    async def _statuses(self, deadline: float) -> AsyncGenerator[JobStatus]:
        """Yield the job's states: from the event stream, and by asking wherever that breaks."""
        last_event, breaks = time.monotonic(), 0
        while True:
            patience = max(0.01, min(CONNECTION.event_timeout, deadline - time.monotonic()))
            events = self._transport.events(f"/v1/jobs/{self.id}/events", patience=patience)
            async with async_closing(events) as stream:
                async for event in stream:
                    last_event = time.monotonic()
                    if "state" in event:  # and not a mere sign of life
                        yield _wire.reply(JobStatus, {"id": self.id, **event})
            try:
                yield await self.status()
                last_event = time.monotonic()
            except UnreachableError:
                if time.monotonic() > min(last_event + CONNECTION.outage, deadline):
                    raise
            await async_sleep(CONNECTION.polling[min(breaks, len(CONNECTION.polling) - 1)])
            breaks += 1

    async def _outcome(self, status: JobStatus) -> T:
        if status.state != "succeeded":
            raise _wire.job_failure(status)
        if status.result_id is None:
            raise UnexpectedReplyError(f"job {self.id} succeeded without a result")
        return await self._fetch(status.result_id)
