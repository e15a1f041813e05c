"""Worker processes: what is done in them, and that none outlives whoever leaves."""

import asyncio
import os
import signal
import time
from collections.abc import Sequence
from typing import Any

import anyio
import pytest
from anyio import BrokenWorkerProcess, to_process
from anyio.abc import Process

from modallab.jobs.processes import WorkerProcesses
from modallab.jobs.runner import Lane
from modallab.jobs.settings import JOB


def told() -> int:
    os.write(1, b"a line of its own, as compiled libraries write it\n")
    return os.getpid()


def test_work_is_done_in_another_process_and_what_is_printed_there_does_no_harm() -> None:
    async def main() -> int:
        return await WorkerProcesses(1).run(told)

    assert anyio.run(main) != os.getpid()


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[Process]:
    """The processes that are started."""
    made: list[Process] = []

    async def opened(command: Sequence[str], **options: Any) -> Process:
        made.append(await anyio.open_process(command, **options))
        return made[-1]

    monkeypatch.setattr(to_process, "open_process", opened)
    return made


def test_whoever_leaves_leaves_no_process_at_work(made: list[Process]) -> None:
    async def main() -> None:
        processes = WorkerProcesses(1)
        await processes.run(os.getpid)
        # one at work, one that waits for it
        asking = [asyncio.create_task(processes.run(time.sleep, 60.0)) for _ in range(2)]
        await anyio.sleep(0.1)
        assert made[0].returncode is None
        await processes.leave()
        assert [process.returncode for process in made] == [-signal.SIGKILL]
        assert all(task.cancelled() for task in asking)

    anyio.run(main)


def test_a_process_whose_work_took_too_long_has_ended_when_its_caller_goes_on(made: list[Process]) -> None:
    async def main() -> None:
        processes = WorkerProcesses(1)
        await processes.run(os.getpid)
        with anyio.move_on_after(0.1):
            await processes.run(time.sleep, 60.0)
        assert [process.returncode for process in made] == [-signal.SIGKILL]

    anyio.run(main)


def test_a_process_that_dies_before_it_is_ready_is_a_broken_one(monkeypatch: pytest.MonkeyPatch) -> None:
    async def opened(command: Sequence[str], **options: Any) -> Process:
        process = await anyio.open_process(command, **options)
        process.kill()
        await process.wait()
        return process

    monkeypatch.setattr(to_process, "open_process", opened)

    async def main() -> None:
        with pytest.raises(BrokenWorkerProcess):
            await WorkerProcesses(1).run(os.getpid)

    anyio.run(main)


def priority() -> int:
    return os.getpriority(os.PRIO_PROCESS, 0)


def test_requests_come_before_short_jobs_and_these_before_long_ones() -> None:
    async def main() -> list[int]:
        processes = WorkerProcesses(1)
        lanes = (Lane.LONG, Lane.LONG, Lane.SHORT, Lane.SHORT)
        return [await processes.run(priority, lane=lane) for lane in lanes]

    low, again, *short = anyio.run(main)
    lowest = 19
    assert low == again == min(priority() + JOB.long_niceness, lowest)
    assert short == 2 * [min(priority() + JOB.short_niceness, lowest)]


def test_a_short_job_does_not_wait_for_a_long_one_however_many_wait() -> None:
    async def main() -> None:
        processes = WorkerProcesses(2, most_long=1)
        waiting = [asyncio.create_task(processes.run(time.sleep, 60.0, lane=Lane.LONG)) for _ in range(9)]
        await anyio.sleep(0.1)
        with anyio.fail_after(10):  # a process starts in a second or two
            await processes.run(os.getpid)
        assert not any(task.done() for task in waiting)
        await processes.leave()

    anyio.run(main)
