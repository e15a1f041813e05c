"""Operations as the OpenAPI document describes them, to hold requests against."""

from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from fastapi import HTTPException, Request
from fastapi.exceptions import RequestValidationError
from starlette._utils import get_route_path
from starlette.datastructures import Headers, ImmutableMultiDict
from starlette.routing import compile_path

from modallab.api.faults import Place
from modallab.api.schema_walk import property_names

Document = Mapping[str, Any]
FORM_TYPE = "multipart/form-data"


@dataclass(frozen=True)
class Operation:
    """One method at one path: the names of its query parameters, and its bodies by content type."""

    query: frozenset[str]
    bodies: Mapping[str, Any]
    definitions: Mapping[str, Any]

    def body_names(self, place: Place) -> list[str]:
        """Return the names that the body may have at a place."""
        schemas = [content["schema"] for content in self.bodies.values()]
        names = (property_names(schema, self.definitions, place) for schema in schemas[:1])
        return next(names, [])


_UNKNOWN = Operation(frozenset(), {}, {})


class Operations:
    """Operations by path and method, read from the document when first asked for."""

    def __init__(self, document: Callable[[], Document]) -> None:
        self._document = document

    @cached_property
    def _by_path(self) -> list[tuple[Any, dict[str, Operation]]]:
        """Pairs of path pattern and operations by method, paths without parameters first."""
        document = self._document()
        definitions = document["components"]["schemas"]
        paths = sorted(document["paths"].items(), key=lambda pair: "{" in pair[0])
        return [
            (
                compile_path(path)[0],
                {name.upper(): _operation(operation, definitions) for name, operation in methods.items()},
            )
            for path, methods in paths
        ]

    def of(self, request: Request) -> Operation:
        """Return the operation that a request calls; one without parameters where there is none."""
        path = get_route_path(request.scope)
        for pattern, methods in self._by_path:
            if pattern.match(path) and request.method in methods:
                return methods[request.method]
        return _UNKNOWN

    def methods(self, path: str) -> list[str]:
        """Return the methods that a path takes, sorted; a path without parameters goes first."""
        return next((sorted(methods) for pattern, methods in self._by_path if pattern.match(path)), [])


def _operation(operation: Mapping[str, Any], definitions: Mapping[str, Any]) -> Operation:
    query = (spec["name"] for spec in operation.get("parameters", ()) if spec["in"] == "query")
    return Operation(frozenset(query), operation.get("requestBody", {}).get("content", {}), definitions)


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
    if request.method not in operations.methods(get_route_path(request.scope)):
        # A path such as `/structures/import` is no id of the route with a parameter.
        raise HTTPException(405, "Method Not Allowed")
    operation = operations.of(request)
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
