"""A service whose heavy requests are answered by a worker process."""

from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from anyio.from_thread import start_blocking_portal

from modallab.api.app import create_app, job_book
from modallab.api.offloading.processes import RequestProcesses
from modallab.api.settings import ServiceSettings
from modallab.jobs.inline import InlineRunner


@pytest.fixture(scope="module")
def offloading(settings: ServiceSettings, service: Any) -> Iterator[Any]:
    """The service of `service`, with one process for heavy requests."""
    with ExitStack() as stack:
        portal = stack.enter_context(start_blocking_portal())

        async def processes() -> RequestProcesses:
            return RequestProcesses(settings, most=1)

        made = portal.call(processes)
        runner = InlineRunner(job_book(settings), settings.store_place)
        stack.callback(portal.call, made.leave)
        yield type(service)(create_app(settings, runner, made), portal)
