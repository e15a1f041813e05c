"""Operations as the OpenAPI document describes them, for the check of requests."""

from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from fastapi import HTTPException, Request
from fastapi.exceptions import RequestValidationError
from starlette.datastructures import Headers, ImmutableMultiDict
from starlette.routing import compile_path

from modallab.api.faults import Place
from modallab.api.schema_walk import property_names

Document = Mapping[str, Any]
FORM_TYPE = "multipart/form-data"


@dataclass(frozen=True)
class Operation:
    """One method at one path: the names of its query parameters, and its bodies by content type."""

    path: str
    query: frozenset[str]
    bodies: Mapping[str, Any]
    definitions: Mapping[str, Any]

    def body_names(self, place: Place) -> list[str]:
        """Return the names that the body may have at a place."""
        schemas = [content["schema"] for content in self.bodies.values()]
        names = (property_names(schema, self.definitions, place) for schema in schemas[:1])
        return next(names, [])


_UNKNOWN = Operation("", frozenset(), {}, {})


class Operations:
    """Operations by the names of their routes, read from the document when first asked for."""

    def __init__(self, document: Callable[[], Document]) -> None:
        self._document = document

    @cached_property
    def _by_name(self) -> dict[str, Operation]:
        """Operations by id, which is the name of the route."""
        document = self._document()
        definitions = document["components"]["schemas"]
        return {
            operation["operationId"]: _operation(path, operation, definitions)
            for path, methods in document["paths"].items()
            for operation in methods.values()
        }

    @cached_property
    def _methods(self) -> dict[str, list[str]]:
        """Methods by path, paths without parameters first."""
        paths = sorted(self._document()["paths"].items(), key=lambda pair: "{" in pair[0])
        return {path: sorted(map(str.upper, methods)) for path, methods in paths}

    def of(self, request: Request) -> Operation:
        """Return the operation of the route that a request matched; an empty one without a route."""
        return self._by_name.get(getattr(request.scope.get("route"), "name", ""), _UNKNOWN)

    def takes(self, path: str, method: str) -> bool:
        """Return whether a path without parameters takes a method; any method for any other path."""
        return method in self._methods.get(path, (method,))

    def methods(self, path: str) -> list[str]:
        """Return the methods that a path takes, sorted; a path without parameters goes first."""
        templates = (template for template in self._methods if compile_path(template)[0].match(path))
        return self._methods.get(next(templates, ""), [])


def _operation(path: str, operation: Mapping[str, Any], definitions: Mapping[str, Any]) -> Operation:
    query = (spec["name"] for spec in operation.get("parameters", ()) if spec["in"] == "query")
    content = operation.get("requestBody", {}).get("content", {})
    return Operation(path, frozenset(query), content, definitions)


async def check_request(request: Request) -> None:
    """Refuse an unknown query parameter or form field, and a body of another content type.

    Raises
    ------
    HTTPException
        405, if the path does not take the method; 415, if the body has another content type.
    RequestValidationError
        If a query parameter or a field of a form does not exist.
    """
    operations: Operations = request.app.state.operations
    operation = operations.of(request)
    # A path such as `/structures/import` is no id of the route with a parameter.
    if not operations.takes(operation.path.format(**request.path_params), request.method):
        raise HTTPException(405, "Method Not Allowed")
    _check_content_type(request.headers, list(operation.bodies))
    unknown = _unknown("query", request.query_params, operation.query)
    if FORM_TYPE in request.headers.get("content-type", "") and FORM_TYPE in operation.bodies:
        names = property_names(operation.bodies[FORM_TYPE]["schema"], operation.definitions, ())
        unknown += _unknown("body", await request.form(), names)
    if unknown:
        raise RequestValidationError(unknown)


def _unknown(part: str, sent: ImmutableMultiDict[str, Any], expected: Container[str]) -> list[dict[str, Any]]:
    """Return pydantic's errors of names that are not allowed."""
    return [
        {"type": "extra_forbidden", "loc": (part, name), "msg": "", "input": value}
        for name, value in sent.items()
        if name not in expected
    ]


def _check_content_type(headers: Headers, expected: list[str]) -> None:
    sent = headers.get("content-type", "").partition(";")[0].strip().lower()
    has_body = headers.get("content-length", "0") != "0" or "transfer-encoding" in headers
    if not expected or not has_body or sent in expected:
        return
    detail = f"send the body as {' or '.join(expected)}, not as {sent or 'an unnamed content type'}"
    context = {"field": "Content-Type", "value": sent, "allowed": expected}
    raise HTTPException(415, {"detail": detail, "context": context}, {"Accept": ", ".join(expected)})
