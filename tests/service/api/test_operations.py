"""Operations as the routes declare them: the OpenAPI document, made another way, tells the same."""

from typing import Any

import pytest

from modallab.api.document import operations
from modallab.api.operations import FORM_TYPE, Operation
from modallab.api.schema_walk import property_names


@pytest.fixture(scope="module")
def document(service: Any) -> Any:
    return service.get("/openapi.json")


def test_each_is_that_of_the_document(service: Any, document: Any) -> None:
    schemas = document["components"]["schemas"]

    def operation(path: str, told: Any) -> Operation:
        query = {spec["name"] for spec in told.get("parameters", ()) if spec["in"] == "query"}
        bodies = told.get("requestBody", {}).get("content", {})
        form = property_names(bodies[FORM_TYPE]["schema"], schemas, ()) if FORM_TYPE in bodies else ()
        return Operation(path, frozenset(query), tuple(bodies), frozenset(form))

    expected = {told["operationId"]: operation(path, told) for path, _, told in operations(document)}
    assert service.app.state.operations.by_name == expected


def test_methods_of_a_path_are_those_of_the_document(service: Any, document: Any) -> None:
    for path, methods in document["paths"].items():
        assert service.app.state.operations.methods(path) == sorted(map(str.upper, methods))
