"""Worker processes, separate from the server and all ended with it."""

import asyncio
import math
import os
from collections.abc import Callable, Coroutine
from functools import partial
from typing import Any, TypeVar, TypeVarTuple

from anyio import CapacityLimiter, to_process

from modallab.jobs.stdout_guard import answers_apart

Arguments = TypeVarTuple("Arguments")
Outcome = TypeVar("Outcome")


class WorkerProcesses:
    """Worker processes of one event loop, limited in number."""

    def __init__(self, most: int) -> None:
        self._limiter = CapacityLimiter(most)
        self._unlimited = CapacityLimiter(math.inf)
        self._starting: set[asyncio.Task[Any]] = set()
        self._working: set[asyncio.Task[Any]] = set()

    async def run(self, work: Callable[[*Arguments], Outcome], *arguments: *Arguments) -> Outcome:
        """Return the result of a function in a worker process; cancelling the waiting task kills the process.

        Raises
        ------
        BrokenWorkerProcess
            If the process dies under the work.
        """
        return await _tracked(self._in_process(work, *arguments), self._working)

    async def _in_process(self, work: Callable[[*Arguments], Outcome], *arguments: *Arguments) -> Outcome:
        async with self._limiter:
            # A process that is cancelled while it starts is left behind (agronholm/anyio#1337).
            start = to_process.run_sync(os.getpid, limiter=self._unlimited)
            await asyncio.shield(_tracked(start, self._starting))
            call = partial(_with_stdout_guard, work, *arguments)
            return await to_process.run_sync(call, cancellable=True, limiter=self._unlimited)

    async def leave(self) -> None:
        """Kill the running processes, and wait for their end."""
        for task in self._working:
            task.cancel()
        await asyncio.gather(*self._working, *self._starting, return_exceptions=True)


def _with_stdout_guard(work: Callable[[*Arguments], Outcome], *arguments: *Arguments) -> Outcome:
    with answers_apart():
        return work(*arguments)


def _tracked(coroutine: Coroutine[Any, Any, Outcome], tasks: set[asyncio.Task[Any]]) -> asyncio.Task[Outcome]:
    """Return a task for a coroutine, in a set of tasks until it ends."""
    task = asyncio.create_task(coroutine)
    tasks.add(task)
    task.add_done_callback(tasks.discard)
    return task
