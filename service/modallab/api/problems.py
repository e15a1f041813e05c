"""The only place where errors meet HTTP: problem documents of RFC 9457."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any

import structlog
from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse

from modallab.api.faults import Fault, faults
from modallab.core import errors
from modallab.jobs.runner import QueueFullError
from modallab.jobs.work import INTERNAL, describe
from modallab.store.base import InUseError, StoredDataError

_log = structlog.get_logger()

# The nearest class counts; what an error means never depends on its status.
STATUS: Mapping[type[errors.ModalLabError], int] = {
    errors.ModalLabError: 422,
    errors.NotFoundError: 404,
    errors.CancelledError: 409,
    errors.MissingExtraError: 501,
    InUseError: 409,
    QueueFullError: 503,
    StoredDataError: 500,
}
# Written out, for the phrases of Python's own `http` module differ from version to version.
_CODES = {400: "bad_request", 404: "not_found", 405: "method_not_allowed", 413: "content_too_large"}
_RETRY_AFTER = "5"  # s: about the length of a short job
_MOST = 20  # faults that are listed


class Problem(BaseModel):
    """An error, RFC 9457: `code` is stable, `context` names the field, its value, what is allowed."""

    type: str
    title: str
    status: int
    detail: str
    code: str
    context: dict[str, Any]


def document(status: int, code: str, title: str, detail: str, context: Mapping[str, Any]) -> dict[str, Any]:
    """Return a problem document."""
    problem = {"type": f"/problems/{code}", "title": title, "status": status, "detail": detail}
    return problem | {"code": code, "context": {key: _plain(value) for key, value in context.items()}}


def response(problem: Mapping[str, Any]) -> JSONResponse:
    """Return the reply that carries a problem document."""
    headers = {"Retry-After": _RETRY_AFTER} if problem["status"] == 503 else None
    return JSONResponse(problem, problem["status"], media_type="application/problem+json", headers=headers)


def of_job(error: Mapping[str, Any]) -> dict[str, Any]:
    """Return the problem document of a failed job, from what the book says of it."""
    status = _STATUS_BY_CODE.get(error["code"], 500)
    return document(status, **error)


def _plain(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
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
    return response(document(status, **describe(error)))


def _of_validation(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    found = _faults(error)[:_MOST]
    first = found[0]
    context = {"field": first.field, "value": first.value, "errors": [asdict(fault) for fault in found]}
    detail = f"{first.field}: {first.message}"
    return response(document(422, "invalid_request", "The request is not valid", detail, context))


def _faults(error: RequestValidationError) -> list[Fault]:
    """Return what is wrong with a request's body, path and query."""
    told = error.errors()
    inside = [fault | {"loc": fault["loc"][1:]} for fault in told if fault["loc"][0] == "body"]
    outside = [fault for fault in told if fault["loc"][0] != "body"]
    return faults(inside, error.body, ("body",)) + faults(outside, None, ())


def _of_http(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)
    code = _CODES.get(error.status_code, f"http_{error.status_code}")
    title = code.replace("_", " ").capitalize()
    reply = response(document(error.status_code, code, title, str(error.detail), {}))
    reply.headers.update(error.headers or {})
    return reply


def _of_fault(request: Request, error: Exception) -> JSONResponse:
    _log.error("unhandled", path=request.url.path, error=repr(error))  # the server logs the traceback
    return response(
        document(500, INTERNAL["code"], INTERNAL["title"], "the service failed; its log says why", {})
    )


def install(app: FastAPI) -> None:
    """Answer every error of the app with a problem document, and say so in its OpenAPI document."""
    app.add_exception_handler(errors.ModalLabError, _of_domain)
    app.add_exception_handler(RequestValidationError, _of_validation)
    app.add_exception_handler(HTTPException, _of_http)
    app.add_exception_handler(Exception, _of_fault)


# For the `responses` of routers: FastAPI would otherwise announce a body of its own for 422.
RESPONSES: dict[int | str, dict[str, Any]] = {
    "4XX": {
        "description": "What was asked cannot be done",
        "content": {"application/problem+json": {"schema": Problem.model_json_schema()}},
    }
}
