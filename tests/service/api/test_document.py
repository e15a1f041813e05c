"""The OpenAPI document: complete, valid, and the one that is checked in."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from openapi_spec_validator import OpenAPIV31SpecValidator

from modallab.api.document import TAGS, operations, written

CHECKED_IN = Path(__file__).parents[3] / "docs" / "openapi.json"
METHODS = ("get", "post", "put", "patch", "delete")
# Schemas whose properties are described with their dataclasses; the list only ever shrinks.


@pytest.fixture(scope="module")
def document(service: Any) -> Any:
    """The OpenAPI document of the running service."""
    return service.get("/openapi.json")


def nodes(value: Any, path: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield every object of a document with its place."""
    if isinstance(value, dict):
        yield path, value
    for key, inner in (
        value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    ):
        yield from nodes(inner, f"{path}/{key}")


def test_the_document_is_the_one_checked_in(service: Any) -> None:
    assert written(service.app.openapi()) == CHECKED_IN.read_text(encoding="utf-8"), "make openapi"


def test_the_document_is_valid(document: Any) -> None:
    OpenAPIV31SpecValidator(document).validate()


def test_every_operation_is_described_and_stable(document: Any) -> None:
    ids = []
    for path, method, operation in operations(document):
        where = f"{method} {path}"
        assert operation["summary"], where
        assert operation["description"], where
        assert len(operation["tags"]) == 1, where
        assert operation["tags"][0] in TAGS, where
        ids.append(operation["operationId"])
    assert len(set(ids)) == len(ids)
    assert all(name == name.lower() and name.isidentifier() for name in ids)


def test_every_parameter_and_property_is_described(document: Any) -> None:
    missing = []
    for path, method, operation in operations(document):
        names = [spec["name"] for spec in operation.get("parameters", ()) if not spec.get("description")]
        missing += [f"{method} {path}: {name}" for name in names]
    for name, schema in document["components"]["schemas"].items():
        if not schema.get("description"):
            missing.append(name)
        fields = [
            field for field, spec in schema.get("properties", {}).items() if not spec.get("description")
        ]
        missing += [f"{name}.{field}" for field in fields]
    assert not missing, "\n".join(missing)


def test_bounds_have_the_names_of_json_schema(document: Any) -> None:
    wrong = {"ge", "gt", "le", "lt", "min_length", "max_length", "multiple_of"}
    found = [
        f"{path}: {sorted(wrong & set(node))}"
        for path, node in nodes(document)
        if wrong & set(node) and not path.endswith("/properties")
    ]
    assert not found, "\n".join(found)


def test_names_that_an_object_may_not_have_are_excluded(document: Any) -> None:
    # other names than those of `patternProperties` would be allowed
    assert not [path for path, node in nodes(document) if "patternProperties" in node]


CLOSED = {
    ("AnalyserIn", "window"): "flat_top",
    ("AnalyserIn", "estimator"): "h1",
    ("ExcitationIn", "kind"): "burst_random",
    ("EffectIn", "kind"): "extra_mass",
    ("CatalogueIn", "name"): "garteur",
    ("ReductionIn", "kind"): "guyan",
    ("MeasurementStart", "route"): "drawn",
    ("MemberChangeIn", "property"): "modulus",
}


@pytest.mark.parametrize(("schema", "field"), CLOSED)
def test_closed_sets_of_names_are_enumerated(document: Any, schema: str, field: str) -> None:
    schemas = document["components"]["schemas"]
    reference = schemas[schema]["properties"][field]["$ref"]
    assert CLOSED[schema, field] in schemas[reference.rpartition("/")[2]]["enum"]


def test_every_error_reply_is_a_problem(document: Any) -> None:
    for path, method, operation in operations(document):
        replies = operation["responses"]
        where = f"{method} {path}"
        assert "422" in replies, where
        assert ("404" in replies) >= ("{id}" in path), where
        assert ("503" in replies) == ("202" in replies), where
        assert {"413", "415"} <= set(replies) or "requestBody" not in operation, where
        for status, reply in replies.items():
            if int(status) >= 400:
                schema = reply["content"]["application/problem+json"]["schema"]
                assert schema == {"$ref": "#/components/schemas/Problem"}, where


# Number, value within its bounds, value beyond: the document says no other limits than the service has.
BOUNDS = [
    ("/v1/rigs", {"drive": "1:+Y", "responses": ["1:+Y"]}, "AnalyserIn", "analyser"),
    ("/v1/rigs", {"drive": "1:+Y", "responses": ["1:+Y"]}, "AccelerometersIn", "accelerometers"),
    ("/v1/rigs", {"drive": "1:+Y", "responses": ["1:+Y"]}, "ExciterIn", "exciter"),
    ("/v1/rigs", {"drive": "1:+Y", "responses": ["1:+Y"]}, "ForceTransducerIn", "force_transducer"),
    ("/v1/rigs", {"drive": "1:+Y", "responses": ["1:+Y"]}, "NoiseIn", "noise"),
]


@pytest.mark.parametrize(("path", "body", "schema", "part"), BOUNDS)
def test_limits_of_a_rig_are_those_of_the_document(
    service: Any, document: Any, path: str, body: Any, schema: str, part: str
) -> None:
    for name, spec in document["components"]["schemas"][schema]["properties"].items():
        bounded = next((s for s in [spec, *spec.get("anyOf", [])] if "maximum" in s), None)
        if bounded is None:
            continue
        for keyword, beyond in (("minimum", -1), ("maximum", 1)):
            limit = bounded[keyword]
            step = 1 if bounded["type"] == "integer" else max(abs(limit), 1e-3) * 1e-3
            if (name, keyword) != ("frequency_min", "maximum"):  # it is below another field, frequency_max
                reply = service.request("POST", path, json=body | {part: {name: limit}})
                assert reply.status_code == 201, (name, limit, reply.text)
            reply = service.request("POST", path, json=body | {part: {name: limit + beyond * step}})
            assert reply.status_code == 422, (name, limit, reply.text)
