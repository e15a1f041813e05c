"""Worker processes, separate from the server and all ended with it.

One more short job can be worked on than long ones, and processes with short jobs have a lower priority than
the service, those with long jobs the lowest: on a single core, too, a request is answered while a short job
is done, and a short job is done while a long one goes on.
"""

import asyncio
import gc
import math
import os
from collections.abc import Callable, Coroutine
from contextlib import nullcontext, suppress
from functools import partial
from typing import Any, TypeVar, TypeVarTuple

from anyio import BrokenWorkerProcess, CancelScope, CapacityLimiter, to_process

from modallab.jobs.runner import Lane
from modallab.jobs.settings import JOB
from modallab.jobs.stdout_guard import answers_apart

Arguments = TypeVarTuple("Arguments")
Outcome = TypeVar("Outcome")


class WorkerProcesses:
    """Worker processes of one event loop, limited in number.

    Parameters
    ----------
    most
        Number of processes that work at a time.
    most_long
        Number of them that may have long jobs.
    """

    def __init__(self, most: int, *, most_long: int = 1) -> None:
        self._limiter, self._long = CapacityLimiter(most), CapacityLimiter(most_long)
        self._unlimited = CapacityLimiter(math.inf)
        self._starting: set[asyncio.Task[Any]] = set()
        self._working: set[asyncio.Task[Any]] = set()

    async def run(
        self, work: Callable[[*Arguments], Outcome], *arguments: *Arguments, lane: Lane = Lane.SHORT
    ) -> Outcome:
        """Return the result of a function in a worker process; cancelling the waiting task kills the process.

        Raises
        ------
        BrokenWorkerProcess
            If the process dies under the work.
        """
        task = tracked(self._in_process(lane, partial(work, *arguments)), self._working)
        try:
            return await asyncio.shield(task)
        except asyncio.CancelledError:
            if not task.done():
                # Once only: anyio repeats a cancellation, and the second would leave the killed process open.
                task.cancel()
                with CancelScope(shield=True):
                    await asyncio.wait([task])
            raise

    async def _in_process(self, lane: Lane, work: Callable[[], Outcome]) -> Outcome:
        async with self._long if lane is Lane.LONG else nullcontext(), self._limiter:
            while True:
                # A process that is cancelled while it starts is left behind (agronholm/anyio#1337).
                # It then imports what the work needs: garbage is not collected meanwhile.
                start = to_process.run_sync(gc.disable, limiter=self._unlimited)
                try:
                    await asyncio.shield(tracked(start, self._starting))
                except ProcessLookupError as error:  # anyio kills what is dead already
                    raise BrokenWorkerProcess("a worker process died at its start") from error
                call = partial(_at_priority, lane, work)
                done = await to_process.run_sync(call, cancellable=True, limiter=self._unlimited)
                if done is not None:
                    return done[0]
                # Nobody may raise a priority again: that process makes room for a new one.
                with suppress(BrokenWorkerProcess):
                    await to_process.run_sync(_end_if_long, limiter=self._unlimited)

    async def leave(self) -> None:
        """Kill the running processes, and wait for their end."""
        for task in self._working:
            if not task.cancelling():
                task.cancel()
        await asyncio.gather(*self._working, *self._starting, return_exceptions=True)


def _priority_difference() -> int:
    """Return how much lower the priority of this process is than that of the one that started it."""
    own, parent = (os.getpriority(os.PRIO_PROCESS, pid) for pid in (0, os.getppid()))
    return own - parent


def _at_priority(lane: Lane, work: Callable[[], Outcome]) -> tuple[Outcome] | None:
    """Return the result of work at the priority of its lane; None if this process has a lower one."""
    missing = (JOB.long_niceness if lane is Lane.LONG else JOB.short_niceness) - _priority_difference()
    if missing < 0:
        return None
    os.nice(missing)
    gc.enable()
    with answers_apart():
        return (work(),)


def _end_if_long() -> None:
    if _priority_difference() > JOB.short_niceness:
        os._exit(0)


def tracked(coroutine: Coroutine[Any, Any, Outcome], tasks: set[asyncio.Task[Any]]) -> asyncio.Task[Outcome]:
    """Return a task for a coroutine, in a set of tasks until it ends."""
    task = asyncio.create_task(coroutine)
    tasks.add(task)
    task.add_done_callback(tasks.discard)
    return task
