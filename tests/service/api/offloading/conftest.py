"""A service whose heavy requests are answered by a worker process."""

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import pytest
from anyio.from_thread import start_blocking_portal

from modallab.api.app import create_app
from modallab.api.offloading import processes
from modallab.api.offloading.processes import RequestProcesses
from modallab.api.offloading.settings import OFFLOADING
from modallab.api.runners import job_book
from modallab.api.settings import ServiceSettings
from modallab.jobs.inline import InlineRunner

# Other tests fill the cores: on such a machine a process took 17 s to start, and 8 s to answer.
PATIENT = replace(OFFLOADING, seconds=300.0, waiting_seconds=300.0)


@pytest.fixture(scope="module")
def offloading(settings: ServiceSettings, service: Any) -> Iterator[Any]:
    """The service of `service`, with one process for heavy requests."""
    with ExitStack() as stack:
        stack.enter_context(pytest.MonkeyPatch.context()).setattr(processes, "OFFLOADING", PATIENT)
        portal = stack.enter_context(start_blocking_portal())

        async def make() -> RequestProcesses:
            return RequestProcesses(settings, most=1)

        made = portal.call(make)
        runner = InlineRunner(job_book(settings), settings.store_place)
        stack.callback(portal.call, made.leave)
        yield type(service)(create_app(settings, runner, made), portal)
