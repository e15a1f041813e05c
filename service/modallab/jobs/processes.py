"""Worker processes: work done apart from the server, none of them left behind."""

import asyncio
import math
import os
from collections.abc import Callable, Coroutine
from functools import partial
from typing import Any, TypeVar, TypeVarTuple

from anyio import CapacityLimiter, to_process

from modallab.jobs.stdout_guard import answers_apart

Given = TypeVarTuple("Given")
Made = TypeVar("Made")


class WorkerProcesses:
    """At most so many processes of one event loop."""

    def __init__(self, most: int) -> None:
        self._limiter = CapacityLimiter(most)
        self._unlimited = CapacityLimiter(math.inf)
        self._starting: set[asyncio.Task[Any]] = set()
        self._working: set[asyncio.Task[Any]] = set()

    async def run(self, work: Callable[[*Given], Made], *given: *Given) -> Made:
        """Return what a process makes of some work; whoever waits for it may be cancelled, which kills it.

        Raises
        ------
        BrokenWorkerProcess
            If the process dies under the work.
        """
        return await _kept(self._in_process(work, *given), self._working)

    async def _in_process(self, work: Callable[[*Given], Made], *given: *Given) -> Made:
        async with self._limiter:
            # A process that is cancelled while it starts is left behind (agronholm/anyio#1337).
            start = to_process.run_sync(os.getpid, limiter=self._unlimited)
            await asyncio.shield(_kept(start, self._starting))
            made = partial(_apart, work, *given)
            return await to_process.run_sync(made, cancellable=True, limiter=self._unlimited)

    async def leave(self) -> None:
        """Kill what is under way, and wait until it is gone."""
        for task in self._working:
            task.cancel()
        await asyncio.gather(*self._working, *self._starting, return_exceptions=True)


def _apart(work: Callable[[*Given], Made], *given: *Given) -> Made:
    with answers_apart():
        return work(*given)


def _kept(made: Coroutine[Any, Any, Made], among: set[asyncio.Task[Any]]) -> asyncio.Task[Made]:
    """Return what is to be made as a task, among others until it ends."""
    task = asyncio.create_task(made)
    among.add(task)
    task.add_done_callback(among.discard)
    return task
