"""The processes that answer heavy requests: few, each with limits; who finds none free comes again."""

import asyncio
import os
import tempfile
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from pathlib import Path
from typing import Any

import anyio
import structlog
from anyio import BrokenWorkerProcess, to_thread
from starlette.requests import Request
from starlette.responses import FileResponse, Response

from modallab.api.offloading.confinement import OUT_OF_MEMORY, OUT_OF_TIME
from modallab.api.offloading.forwarding import Answered, Forwarded, forwarded, remove, reply_of
from modallab.api.offloading.settings import OFFLOADING
from modallab.api.offloading.weight import is_form
from modallab.api.offloading.worker import answer, prepare
from modallab.api.settings import ServiceSettings
from modallab.core.errors import InvalidInputError, ModalLabError
from modallab.jobs.processes import WorkerProcesses, tracked

_log = structlog.get_logger()


class BusyError(ModalLabError):
    """As many heavy requests are answered as may be at once; try again soon."""

    code = "busy"


class TooCostlyError(InvalidInputError):
    """A request that takes more memory or time than one may."""

    code = "too_costly"


class RequestProcesses:
    """Worker processes of one event loop that answer heavy requests."""

    def __init__(self, settings: ServiceSettings, *, most: int | None = None) -> None:
        self._settings = settings
        self._most = max(2, (os.cpu_count() or 1) - 1) if most is None else most
        self._free = asyncio.Semaphore(self._most)
        self._processes = WorkerProcesses(self._most)
        self._under_way: dict[object, asyncio.Future[Response]] = {}
        self._starting: set[asyncio.Task[Any]] = set()

    async def answer(self, request: Request) -> Response:
        """Return the reply to a request, from a worker process; the same request at once is answered once.

        Raises
        ------
        BusyError
            If none is free for a while.
        TooCostlyError
            If the reply takes too much memory or time.
        """
        if request.method != "GET":
            return await self._answer(request)
        key = _key(request)
        if (first := self._under_way.get(key)) is not None:
            reply = await asyncio.shield(first)
            if not isinstance(reply, FileResponse):  # whose file is sent once
                return Response(reply.body, reply.status_code, dict(reply.headers))
            return await self._answer(request)
        future = self._under_way[key] = asyncio.get_running_loop().create_future()
        try:
            reply = await self._answer(request)
            future.set_result(reply)
            return reply
        except BaseException as error:
            future.set_exception(error if isinstance(error, Exception) else _busy(self._most))
            future.exception()  # nobody may have waited for it
            raise
        finally:
            del self._under_way[key]

    async def _answer(self, request: Request) -> Response:
        folder = Path(await to_thread.run_sync(tempfile.mkdtemp, None, "modallab-"))
        try:
            question = await forwarded(request, folder)
            with _deadline(request, self._most):
                async with self._process():
                    answered = await self._answered(request, question)
            return await to_thread.run_sync(reply_of, answered, folder)
        except BaseException:
            remove(folder)
            raise

    @asynccontextmanager
    async def _process(self) -> AsyncIterator[None]:
        """Hold one of the processes, as soon as one is free."""
        try:
            with anyio.fail_after(OFFLOADING.waiting_seconds):
                await self._free.acquire()
        except TimeoutError:
            raise _busy(self._most) from None
        try:
            yield
        finally:
            self._free.release()

    async def _answered(self, request: Request, question: Forwarded) -> Answered:
        """Return what a process answers; what only reads is asked of a second one if the first was killed.

        One that ended itself beyond a limit would do so again.
        """
        if request.method == "GET":
            with suppress(BrokenWorkerProcess):
                return await self._answered_once(request, question)
        try:
            return await self._answered_once(request, question)
        except BrokenWorkerProcess:
            raise self._too_costly(request, "memory") from None

    async def _answered_once(self, request: Request, question: Forwarded) -> Answered:
        try:
            await self._prepared()
            return await self._processes.run(answer, self._settings, question)
        except BrokenWorkerProcess:
            for reason in (OUT_OF_TIME, OUT_OF_MEMORY):
                if (question.folder / reason).exists():
                    raise self._too_costly(request, reason) from None
            raise
        except MemoryError:
            raise self._too_costly(request, "memory") from None

    async def _prepared(self) -> None:
        """Wait for a process that has started; a start goes on after a request that cannot wait."""
        await asyncio.shield(tracked(self._processes.run(prepare, self._settings), self._starting))

    @staticmethod
    def _too_costly(request: Request, what: str) -> "TooCostlyError":
        _log.warning("a process that answered a request ended", path=request.url.path, too_much=what)
        return too_costly(request, f"the reply takes too much {what}")

    async def leave(self) -> None:
        """Kill the processes that answer, and wait for their end."""
        await self._processes.leave()


def _key(request: Request) -> object:
    """Return what tells a request from others: whoever may see the reply of one may see that of its equal."""
    headers = sorted(pair for pair in request.scope["headers"] if pair[0] != b"x-request-id")
    return request.url.path, request.url.query, tuple(headers)


@contextmanager
def _deadline(request: Request, most: int) -> Iterator[None]:
    """Give a request so much time that all are answered in time; without an answer the machine is busy."""
    try:
        with anyio.fail_after(OFFLOADING.file_seconds if is_form(request) else OFFLOADING.seconds):
            yield
    except TimeoutError:
        raise _busy(most) from None


def _busy(most: int) -> BusyError:
    return BusyError("as many heavy requests are answered as may be at once: try again soon", allowed=most)


def too_costly(request: Request, message: str) -> TooCostlyError:
    """Return the error of a request that takes too much."""
    field, value = next(iter(request.path_params.items()), ("file" if is_form(request) else "body", None))
    return TooCostlyError(
        message, field=field, value=value, allowed="a smaller model or file, or fewer modes"
    )
