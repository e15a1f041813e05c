"""The only place where errors meet HTTP: problem documents of RFC 9457."""

import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from functools import partial
from typing import Any

import structlog
from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, ConfigDict, Field
from sqlalchemy.exc import DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse

from modallab.api.faults import Fault, faults
from modallab.api.limits import JOB_STREAM, READINESS, REPLY
from modallab.api.offloading.processes import BusyError, too_costly
from modallab.api.operations import Operations
from modallab.core import errors
from modallab.jobs.outages import is_outage
from modallab.jobs.runner import KeyReusedError, NotReadyError, QueueFullError, QueueQuotaError
from modallab.jobs.work import INTERNAL, describe
from modallab.store.base import ForbiddenError, InTrashError, InUseError, StoredDataError, UnauthorisedError
from modallab.store.quotas import StorageQuotaError

_log = structlog.get_logger()

# The nearest class counts; what an error means never depends on its status.
STATUS: Mapping[type[errors.ModalLabError], int] = {
    errors.ModalLabError: 422,
    errors.NotFoundError: 404,
    errors.CancelledError: 409,
    errors.MissingExtraError: 501,
    ForbiddenError: 403,
    InTrashError: 409,
    InUseError: 409,
    KeyReusedError: 409,
    NotReadyError: 503,
    QueueFullError: 503,
    QueueQuotaError: 429,
    StorageQuotaError: 429,
    BusyError: 503,
    StoredDataError: 500,
    UnauthorisedError: 401,
}
# Written out, for the phrases of Python's own `http` module differ from version to version.
CODES: Mapping[int, str] = {
    400: "bad_request",
    404: "not_found",
    405: "method_not_allowed",
    413: "content_too_large",
    415: "unsupported_media_type",
}
TITLES: Mapping[str, str] = {
    "assignment": "The assignment does not allow this",
    "bad_request": "The request cannot be read",
    "busy": "The service answers as many heavy requests as it may",
    "cancelled": "The job was cancelled",
    "content_too_large": "The body is too large",
    "diverged": "The iteration diverged",
    "in_trash": "What it was made from is in the trash",
    "in_use": "Other results were made from it",
    "executor_taken": "Another process runs jobs under this name",
    "forbidden": "This is not allowed",
    "internal": "The service failed",
    "invalid_input": "A value has no meaning",
    "invalid_request": "The request is not valid",
    "key_reused": "The key named another request",
    "method_not_allowed": "The address does not take this method",
    "missing_extra": "An optional part is not installed",
    "modallab": "The request cannot be carried out",
    "no_mode_in_band": "The band holds no resonance",
    "not_found": "Nothing is stored under this id",
    "queue_full": "The queue of jobs is full",
    "queue_quota": "As many jobs of this key or class wait as may",
    "not_ready": "The service cannot work",
    "service_unavailable": "Database or disk are away",
    "storage_quota": "As much is stored for this key or class as may be",
    "stored_data": "Stored data are damaged",
    "structure": "The structure cannot be analysed",
    "too_costly": "The reply takes more memory or time than one may",
    "time_limit": "The job took too long",
    "unauthorized": "A valid key is needed",
    "underdetermined": "There are fewer equations than unknowns",
    "unknown_dof": "The structure has no such degree of freedom",
    "unsupported_media_type": "The body has another content type than the address takes",
}

_HEADERS: Mapping[int, Mapping[str, str]] = {
    401: {"WWW-Authenticate": "Bearer"},
    429: {"Retry-After": str(JOB_STREAM.retry_after)},
    503: {"Retry-After": str(JOB_STREAM.retry_after)},
}
_HEADERS_BY_CODE: Mapping[str, Mapping[str, str]] = {
    StorageQuotaError.code: {"Retry-After": str(JOB_STREAM.retry_after_removal)},
}
_FIELD_DOC = "name of the field at fault, from the body, path or query; absent where no field is"
_VALUES_DOC = (
    "values allowed: a number, a list, bounds by their names in JSON Schema with their unit, or a "
    "requirement in words"
)


class ProblemContext(BaseModel):
    """The field at fault, its value and the values allowed; more entries where an error has them."""

    model_config = ConfigDict(extra="allow")

    field: str = Field("", description=_FIELD_DOC)
    value: Any = Field(None, description="value that was sent, as JSON; the start of a long one")
    allowed: Any = Field(None, description=_VALUES_DOC)
    errors: list[dict[str, Any]] = Field(
        [], description="every field at fault, as `field`, `message`, `value`, `allowed`"
    )


class Problem(BaseModel):
    """Problem document of RFC 9457, the body of every error."""

    type: str = Field(description="`/problems/` and the code")
    title: str = Field(description="the code in words")
    status: int = Field(description="HTTP status")
    detail: str = Field(description="a sentence on this occurrence")
    code: str = Field(description="stable name of the error")
    context: ProblemContext = Field(description="the field at fault, its value and the values allowed")


def document(status: int, code: str, detail: str, context: Mapping[str, Any]) -> dict[str, Any]:
    """Return a problem document."""
    title = TITLES.get(code, code.replace("_", " ").capitalize())
    problem = {"type": f"/problems/{code}", "title": title, "status": status, "detail": detail}
    return problem | {"code": code, "context": {key: _plain(value) for key, value in context.items()}}


def response(problem: Mapping[str, Any]) -> JSONResponse:
    """Return the reply that carries a problem document."""
    headers = _HEADERS_BY_CODE.get(problem["code"]) or _HEADERS.get(problem["status"])
    return JSONResponse(problem, problem["status"], media_type="application/problem+json", headers=headers)


def of_job(error: Mapping[str, Any]) -> dict[str, Any]:
    """Return the problem document of a failed job, from its error in the book of jobs."""
    status = _STATUS_BY_CODE.get(error["code"], 500)
    return document(status, error["code"], error["detail"], error["context"])


def _plain(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, tuple):
        return list(value)
    if isinstance(value, (list, dict, int, float, str)) or value is None:
        return value
    return str(value)


def _status(cls: type[errors.ModalLabError]) -> int:
    return next(STATUS[base] for base in cls.__mro__ if base in STATUS)


def _family(cls: type[errors.ModalLabError]) -> Iterator[type[errors.ModalLabError]]:
    yield cls
    for child in cls.__subclasses__():
        yield from _family(child)


_STATUS_BY_CODE = {cls.code: _status(cls) for cls in _family(errors.ModalLabError)}


def _of_domain(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, errors.ModalLabError)
    status = _status(type(error))
    if status == 500:
        _log.error("stored data is damaged", detail=str(error), **error.context)
    described = describe(error)
    return response(document(status, described["code"], described["detail"], described["context"]))


def _of_validation(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    listed = _faults(request, error)[: REPLY.faults]
    first = listed[0]
    context = {"field": first.field, "value": first.value, "allowed": first.allowed}
    detail = f"{first.field}: {first.message}"
    entries = [asdict(fault) for fault in listed]
    return response(document(422, "invalid_request", detail, context | {"errors": entries}))


def _faults(request: Request, error: RequestValidationError) -> list[Fault]:
    """Return the faults of a request's body, path and query."""
    errors = error.errors()
    inside = [fault | {"loc": fault["loc"][1:]} for fault in errors if fault["loc"][0] == "body"]
    outside = [fault for fault in errors if fault["loc"][0] != "body"]
    operations: Operations = request.app.state.operations
    query = sorted(operations.of(request).query)
    return faults(inside, error.body, ("body",), partial(operations.body_names, request)) + faults(
        outside, None, (), lambda _: query
    )


def _of_http(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)
    code = CODES.get(error.status_code, f"http_{error.status_code}")
    context: dict[str, Any] = {}
    headers = dict(error.headers or {})
    if error.status_code == 405:
        operations: Operations = request.app.state.operations
        # Starlette names the methods of the first route alone that has this path.
        context["allowed"] = operations.methods(request.url.path)
        headers["Allow"] = ", ".join(context["allowed"])
    detail: Any = error.detail  # FastAPI's class takes more than text
    if isinstance(detail, dict):
        detail, context = detail["detail"], detail["context"]
    reply = response(document(error.status_code, code, str(detail), context))
    reply.headers.update(headers)
    return reply


def _of_fault(request: Request, error: Exception) -> JSONResponse:
    _log.error("unhandled", path=request.url.path, error=repr(error))  # the server logs the traceback
    return response(document(500, INTERNAL["code"], "the service failed; its log says why", {}))


def _of_memory(request: Request, _error: Exception) -> JSONResponse:
    return _of_domain(request, too_costly(request, "the reply takes too much memory"))


class _Seldom:
    """Says a thing at most once a minute."""

    def __init__(self) -> None:
        self._said = -math.inf

    def warn(self, message: str, **more: object) -> None:
        """Log a warning unless one was logged a short while ago."""
        if time.monotonic() - self._said > READINESS.repeated_warning:
            self._said = time.monotonic()
            _log.warning(message, **more)


_SELDOM = _Seldom()


def _of_storage(request: Request, error: Exception) -> JSONResponse:
    if not is_outage(error):
        raise error
    told = str(getattr(error, "orig", None) or error).splitlines()[0]
    _SELDOM.warn("database or disk are away", path=request.url.path, error=told)
    return response(document(503, "service_unavailable", "database or disk are away; try again", {}))


def reply_to(request: Request, error: Exception) -> JSONResponse:
    """Return the reply to a request that an error ended before it came to the handlers installed below."""
    handler = _of_domain if isinstance(error, errors.ModalLabError) else _of_storage
    return handler(request, error)


def install(app: FastAPI) -> None:
    """Answer every error of the app with a problem document."""
    app.add_exception_handler(errors.ModalLabError, _of_domain)
    app.add_exception_handler(RequestValidationError, _of_validation)
    app.add_exception_handler(HTTPException, _of_http)
    for cls in (DBAPIError, PoolTimeout, OSError):
        app.add_exception_handler(cls, _of_storage)
    app.add_exception_handler(MemoryError, _of_memory)
    app.add_exception_handler(Exception, _of_fault)
