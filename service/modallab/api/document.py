"""The OpenAPI document: FastAPI's, with stable names and every error reply."""

import json
from collections.abc import Iterator
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.routing import APIRoute

from modallab.api.gate import COOKIE, OPEN_TO_ALL
from modallab.api.problems import Problem

Json = dict[str, Any]

SUMMARY = "A virtual modal test: measure a structure, read its modes, update its model, find what it lacks."
DESCRIPTION = """\
Units are SI, frequencies are in Hz. A degree of freedom (DoF) is written `node:direction`, for example
`5:+Y`, rotations `5:+RZ`. A complex number is `[re, im]`, a number that is not finite is null. Long work is
a job: the reply is 202 with the job, `GET /v1/jobs/{id}` tells its progress and, at the end, the id of the
result. Nothing is changed in place: a changed structure is a new one. Unknown fields and query parameters
are refused. Every error is a problem document (RFC 9457) of type `application/problem+json`.

Arrays come as an uncompressed NumPy archive (npz) unless `Accept: application/json` asks for JSON.
"""
TAGS = {
    "structures": "Finite element models: described, imported, changed, solved.",
    "rigs": "Declarations of test set-ups, the log book of a test.",
    "measurements": "Frequency response functions (FRFs), simulated on a rig or imported.",
    "modal_models": "Natural frequencies, loss factors and mode shapes, extracted from FRFs or imported.",
    "correlations": "Comparison of measured modes and FRFs with those of a structure.",
    "updates": "Corrections of a structure from measured modes or FRFs.",
    "studies": "Statistics of an updating method over noise levels and random seeds.",
    "diagnoses": "Search for effects that a structure and a rig lack, from a measurement.",
    "assignments": "Measurements for a class with hidden effects, and marks for what students find.",
    "projects": "All that somebody has stored, as one file.",
    "trash": "What was deleted, to be restored within 24 hours.",
    "keys": "API keys, classes of students, sessions of web pages.",
    "jobs": "Progress, results and cancellation of long work.",
    "catalog": "Names, parameters and bounds of everything that can be chosen.",
    "service": "Health and versions of the service.",
}
ERRORS = {
    400: "The body cannot be read",
    401: "The service has keys, and no valid one was sent",
    403: "The key does not allow this, or the page of another origin asks",
    404: "Nothing is stored under an id of the request",
    409: "Other results were made from it, what it was made from is in the trash, or the Idempotency-Key "
    "named another request",
    413: "The body is too large",
    415: "The body has another content type than the operation takes",
    422: "A parameter or a field of the body is not valid",
    429: "As much waits or is stored for this key or class as may; `Retry-After` says when to try again",
    501: "An optional part of the service is not installed",
    503: "The queue of jobs is full; `Retry-After` says when to try again",
}
_SCHEMES: Json = {
    "key": {"type": "http", "scheme": "bearer", "description": "API key; needed once the service has one"},
    "session": {"type": "apiKey", "in": "cookie", "name": COOKIE, "description": "of `POST /v1/sessions`"},
}
_PROBLEM = "application/problem+json"
_STORE_NOTHING = {"keys", "classes", "sessions", "trash"}
_REF = "#/components/schemas/"


def operation_id(route: APIRoute) -> str:
    """Return the name of the handler, which is stable and unique."""
    return route.name


def build(app: FastAPI) -> Json:
    """Return the OpenAPI document of an application."""
    document: Json = get_openapi(
        title=app.title,
        version=app.version,
        summary=SUMMARY,
        description=DESCRIPTION,
        routes=app.routes,
        tags=[{"name": name, "description": text} for name, text in TAGS.items()],
    )
    schemas = document["components"]["schemas"]
    for name in ("HTTPValidationError", "ValidationError"):
        schemas.pop(name, None)
    problem = Problem.model_json_schema(ref_template=_REF + "{model}")
    schemas |= problem.pop("$defs") | {"Problem": problem}
    document["components"]["securitySchemes"] = _SCHEMES
    for path, method, operation in operations(document):
        _add_errors(method, operation, is_public=(method.upper(), path) in OPEN_TO_ALL)
        for spec in operation.get("parameters", ()):
            spec.setdefault("description", spec["schema"].get("description", ""))
        _name_components(operation, schemas)
    _describe_forms(schemas)
    schemas["JobStatus"]["properties"]["error"]["anyOf"][0] = {"$ref": _REF + "Problem"}
    renamed: Json = _rename(document, {name: _short(name) for name in schemas})
    for schema in renamed["components"]["schemas"].values():
        for spec in schema.get("properties", {}).values():
            # An object's default are those of its own fields; generators know none for a model.
            if isinstance(spec.get("default"), dict):
                del spec["default"]
    _strip_titles(renamed["components"])
    _strip_titles(renamed["paths"])
    return renamed


def _name_components(operation: Json, schemas: Json) -> None:
    """Move the named schemas of an operation's replies to the components."""
    for reply in operation["responses"].values():
        for content in reply.get("content", {}).values():
            if name := content["schema"].get("x-component"):
                schemas[name] = {key: v for key, v in content["schema"].items() if key != "x-component"}
                content["schema"] = {"$ref": _REF + name}


def _describe_forms(schemas: Json) -> None:
    """Describe the schemas of forms; a field of a form is present or absent, never null."""
    for name, schema in schemas.items():
        if name.startswith("Body_"):
            schema["description"] = f"Form of `{name.removeprefix('Body_')}`"
            schema["additionalProperties"] = False
            for field in schema["properties"].values():
                if len(field.get("anyOf", ())) == 2 and field["anyOf"][1] == {"type": "null"}:
                    field |= field.pop("anyOf")[0]


def operations(document: Json) -> Iterator[tuple[str, str, Json]]:
    """Yield path, method and operation."""
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            yield path, method, operation


def written(document: Json) -> str:
    """Return a document as its file has it: names sorted, but for the order of preference of media types."""
    return json.dumps(_sorted(document), indent=1, ensure_ascii=False) + "\n"


def _sorted(value: Any, key: str = "") -> Any:
    if isinstance(value, dict):
        names = value if key == "content" else sorted(value)
        return {name: _sorted(value[name], name) for name in names}
    return [_sorted(entry) for entry in value] if isinstance(value, list) else value


def _add_errors(method: str, operation: Json, *, is_public: bool) -> None:
    replies = operation["responses"]
    parameters = operation.get("parameters", [])
    body = operation.get("requestBody")
    is_job = "202" in replies
    statuses = {422}
    if not is_public:
        statuses |= {401, 403}
        operation["security"] = [{name: []} for name in _SCHEMES] + [{}]
    elif body is not None:
        statuses |= {401, 403}
    if body is not None:
        statuses |= {400, 413, 415}
    if any(spec["name"] in ("id", "after") for spec in parameters) or method == "post":
        statuses.add(404)
    if (method == "delete" and "204" in replies) or (method == "post" and "trash" in operation["tags"]):
        statuses.add(409)
    if method == "post" and not _STORE_NOTHING & set(operation["tags"]):
        statuses.add(429)
    if is_job:
        statuses |= {409, 503}
    for status in sorted(statuses):
        replies[str(status)] = _problem_reply(status)


def _problem_reply(status: int) -> Json:
    reply: Json = {
        "description": ERRORS[status],
        "content": {_PROBLEM: {"schema": {"$ref": _REF + "Problem"}}},
    }
    if status in (429, 503):
        schema = {"type": "integer", "minimum": 0}
        reply["headers"] = {"Retry-After": {"description": "s until the next try", "schema": schema}}
    return reply


def _short(name: str) -> str:
    """Return a component's name: FastAPI calls a form `Body_` and the operation."""
    if not name.startswith("Body_"):
        return name
    return "".join(part.capitalize() for part in name.removeprefix("Body_").split("_")) + "Form"


def _rename(value: Any, names: dict[str, str]) -> Any:
    if isinstance(value, dict):
        out = {key: _rename(inner, names) for key, inner in value.items()}
        if isinstance(ref := out.get("$ref"), str) and ref.startswith(_REF):
            out["$ref"] = _REF + names[ref.removeprefix(_REF)]
        if set(names) <= set(out):
            out = {names[key]: inner for key, inner in out.items()}
        return out
    return [_rename(inner, names) for inner in value] if isinstance(value, list) else value


def _strip_titles(value: Any, key: str = "") -> None:
    """Remove the titles that pydantic makes of names: generators take them for names of types."""
    if isinstance(value, dict):
        if key not in ("properties", "schemas") and isinstance(value.get("title"), str):
            del value["title"]
        for name, inner in value.items():
            if name not in ("example", "examples", "default", "const", "enum"):
                _strip_titles(inner, name)
    elif isinstance(value, list):
        for inner in value:
            _strip_titles(inner)
