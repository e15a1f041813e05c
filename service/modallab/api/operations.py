"""Operations as the routes declare them, for the check of requests."""

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from fastapi import HTTPException, Request
from fastapi.dependencies.models import Dependant
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute, RouteContext, iter_route_contexts
from pydantic import BaseModel
from starlette.datastructures import Headers, ImmutableMultiDict
from starlette.routing import BaseRoute, compile_path

from modallab.api.faults import Place
from modallab.api.schema_walk import property_names

Document = Mapping[str, Any]
FORM_TYPE = "multipart/form-data"


@dataclass(frozen=True)
class Operation:
    """One method at one path, with the names that a request may have."""

    path: str
    query: frozenset[str] = frozenset()
    """Names of query parameters."""
    content_types: tuple[str, ...] = ()
    """Media types of the bodies that it takes."""
    form: frozenset[str] = frozenset()
    """Names of the fields of a form."""


_UNKNOWN = Operation("")


class Operations:
    """Operations of an application, by the names of their routes.

    The OpenAPI document tells the same, but takes a second of a start: it is made when first asked for.

    Parameters
    ----------
    routes
        All routes of the application.
    document
        Returns the OpenAPI document.
    """

    def __init__(self, routes: Sequence[BaseRoute], document: Callable[[], Document]) -> None:
        self._routes, self._document = routes, document

    @cached_property
    def _contexts(self) -> list[RouteContext]:
        """Routes of the OpenAPI document."""
        return [
            context
            for context in iter_route_contexts(self._routes)
            if isinstance(context.original_route, APIRoute) and context.include_in_schema
        ]

    @cached_property
    def by_name(self) -> dict[str, Operation]:
        """Operations by the names of their routes, which are the ids of the document."""
        return {str(context.name): _operation(context) for context in self._contexts}

    @cached_property
    def _methods(self) -> dict[str, list[str]]:
        """Methods by path, paths without parameters first."""
        methods: dict[str, set[str]] = {}
        for context in self._contexts:
            methods.setdefault(str(context.path_format), set()).update(context.methods or ())
        return {path: sorted(methods[path]) for path in sorted(methods, key=lambda path: "{" in path)}

    def of(self, request: Request) -> Operation:
        """Return the operation of the route that a request matched; an empty one without a route."""
        return self.by_name.get(_route_name(request), _UNKNOWN)

    def body_names(self, request: Request, place: Place) -> list[str]:
        """Return the names that the body of a request may have at a place."""
        document = self._document()
        for methods in document["paths"].values():
            for operation in methods.values():
                if operation["operationId"] == _route_name(request):
                    contents = operation.get("requestBody", {}).get("content", {}).values()
                    schemas = [content["schema"] for content in contents]
                    definitions = document["components"]["schemas"]
                    names = (property_names(schema, definitions, place) for schema in schemas[:1])
                    return next(names, [])
        return []

    def takes(self, path: str, method: str) -> bool:
        """Return whether a path without parameters takes a method; any method for any other path."""
        return method in self._methods.get(path, (method,))

    def methods(self, path: str) -> list[str]:
        """Return the methods that a path takes, sorted; a path without parameters goes first."""
        templates = (template for template in self._methods if compile_path(template)[0].match(path))
        return self._methods.get(next(templates, ""), [])


def _route_name(request: Request) -> str:
    return str(getattr(request.scope.get("route"), "name", ""))


def _operation(context: RouteContext) -> Operation:
    bodies: dict[str, set[str]] = {}
    if context.body_field is not None:
        names = _names(context.dependant, "body_params")
        bodies[context.body_field.field_info.media_type] = set(names)
    extra = (context.openapi_extra or {}).get("requestBody", {}).get("content", {})
    bodies |= {content_type: set(content["schema"]["properties"]) for content_type, content in extra.items()}
    query = frozenset(_names(context.dependant, "query_params"))
    return Operation(str(context.path_format), query, tuple(bodies), frozenset(bodies.get(FORM_TYPE, ())))


def _names(dependant: Dependant, part: str) -> Iterator[str]:
    """Yield the names of parameters, those of a model one by one, of a route and what it depends on."""
    for field in getattr(dependant, part):
        annotation = field.field_info.annotation
        if part == "query_params" and isinstance(annotation, type) and issubclass(annotation, BaseModel):
            yield from (spec.alias or name for name, spec in annotation.model_fields.items())
        else:
            yield field.alias
    for inner in dependant.dependencies:
        yield from _names(inner, part)


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
    _check_content_type(request.headers, operation.content_types)
    unknown = _unknown("query", request.query_params, operation.query)
    if FORM_TYPE in request.headers.get("content-type", "") and FORM_TYPE in operation.content_types:
        unknown += _unknown("body", await request.form(), operation.form)
    if unknown:
        raise RequestValidationError(unknown)


def _unknown(part: str, sent: ImmutableMultiDict[str, Any], expected: Container[str]) -> list[dict[str, Any]]:
    """Return pydantic's errors of names that are not allowed."""
    return [
        {"type": "extra_forbidden", "loc": (part, name), "msg": "", "input": value}
        for name, value in sent.items()
        if name not in expected
    ]


def _check_content_type(headers: Headers, expected: Sequence[str]) -> None:
    sent = headers.get("content-type", "").partition(";")[0].strip().lower()
    has_body = headers.get("content-length", "0") != "0" or "transfer-encoding" in headers
    if not expected or not has_body or sent in expected:
        return
    detail = f"send the body as {' or '.join(expected)}, not as {sent or 'an unnamed content type'}"
    context = {"field": "Content-Type", "value": sent, "allowed": list(expected)}
    raise HTTPException(415, {"detail": detail, "context": context}, {"Accept": ", ".join(expected)})
