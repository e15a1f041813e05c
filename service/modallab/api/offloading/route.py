"""Routes whose heavy requests are answered by worker processes."""

from collections.abc import Callable, Coroutine
from typing import Any

from fastapi.routing import APIRoute
from starlette.requests import Request
from starlette.responses import Response

from modallab.api.offloading.processes import RequestProcesses
from modallab.api.offloading.settings import OFFLOADING
from modallab.api.offloading.weight import weight_of

_Handler = Callable[[Request], Coroutine[Any, Any, Response]]
_SELDOM_HEAVY = ("DELETE",)


class OffloadedRoute(APIRoute):
    """Answers light requests in a thread of the service, and has heavy ones answered by another process.

    A request that starts a job, or removes something, is never heavy.
    """

    def get_route_handler(self) -> _Handler:
        """Return the function that answers requests."""
        answer_here = super().get_route_handler()
        if self.status_code == 202:
            return answer_here

        async def answer(request: Request) -> Response:
            processes: RequestProcesses | None = request.app.state.processes
            if processes is None or request.method in _SELDOM_HEAVY:
                return await answer_here(request)
            if await weight_of(request, request.app.state.store) <= OFFLOADING.light:
                return await answer_here(request)
            return await processes.answer(request)

        return answer
