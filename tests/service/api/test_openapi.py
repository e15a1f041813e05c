"""Whatever the OpenAPI document allows to be sent, and more, no answer is a fault of the service."""

from contextlib import suppress
from typing import Any

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis.errors import Unsatisfiable
from schemathesis.generation import GenerationMode

CHECKED = settings(
    max_examples=10,  # an operation and mode: some forty operations in half a minute
    deadline=None,
    database=None,
    derandomize=True,
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
)


# A service without keys makes none, and no classes; tests/service/api/test_keys.py sends these with keys.
BEFORE_THE_FIRST_KEY = {
    "/v1/keys": (403,),
    "/v1/keys/{id}/rotate": (403,),
    "/v1/keys/{id}/links": (403,),
    "/v1/classes": (403,),
    "/v1/assignments": (403,),
    "/v1/assignments/{id}/measurements": (403,),
    "/v1/assignments/{id}/submissions": (403,),
    "/v1/assignments/{id}/marks/{student}/words": (403,),
    "/v1/classes/{id}/members": (403,),
    "/v1/classes/{id}/shares": (403,),
    "/v1/sessions": (401,),
}


@pytest.fixture(scope="module")
def document(service: Any) -> Any:
    """The OpenAPI document."""
    return service.get("/openapi.json")


@pytest.fixture(scope="module")
def sizes(service: Any, beam: str) -> Any:
    """Numbers of nodes and members of the beam."""
    return service.get(f"/v1/structures/{beam}")


def test_every_post_has_an_example(document: Any) -> None:
    for path, methods in document["paths"].items():
        for media_type, content in methods.get("post", {}).get("requestBody", {}).get("content", {}).items():
            assert "examples" in content or media_type == "multipart/form-data", path


def test_the_examples_are_good_requests(service: Any, document: Any, beam: str) -> None:
    for path, methods in document["paths"].items():
        contents = methods.get("post", {}).get("requestBody", {}).get("content", {})
        for example in contents.get("application/json", {}).get("examples", {}).values():
            reply = service.request("POST", path.replace("{id}", beam), json=example["value"])
            # ids in an example are made up, all else must hold
            assert reply.status_code in (201, 202, 404, *BEFORE_THE_FIRST_KEY.get(path, ())), (
                path,
                reply.text,
            )


# Rules between fields, and the content of files, which no JSON schema tells: (path, field).
BEYOND_A_SCHEMA = {
    ("/v1/structures/{id}/changes", "factor"),
    ("/v1/structures/{id}/changes", "value"),
    ("/v1/rigs", "drive"),
    # 3:X and 3:+X are one DoF
    ("/v1/rigs", "drives"),
    ("/v1/rigs", "responses"),
    ("/v1/rigs", "stinger"),
    ("/v1/rigs", "exciter.coil"),
    # as many as the route and the size of the test leave room for
    ("/v1/measurements", "records"),
    ("/v1/measurements", "estimates"),
    ("/v1/modal-models/import", "shape"),
    ("/v1/modal-models/import", "file"),
    ("/v1/structures/import", "file"),
    ("/v1/structures/import", "mesh"),
    ("/v1/structures/import", "damping"),
    ("/v1/measurements/import", "file"),
    ("/v1/projects/import", "file"),
    *(
        ("/v1/measurements/import", field)  # grammars of their own, and JSON within a form
        for field in ("unit", "scale", "map", "outputs", "inputs", "columns", "variables")
    ),
    # parameters of a reduction depend on its kind
    ("/v1/structures/{id}/expanded-modes", "reduction"),
    ("/v1/correlations", "reduction"),
    # modes or FRFs, as the method takes them
    ("/v1/updates", "modal_model_id"),
    ("/v1/updates", "measurement_id"),
    ("/v1/updates", "noise_floor"),
    ("/v1/updates", "bands"),
    ("/v1/updates", "exclude"),
    # a direct method has no coefficients
    ("/v1/updates", "parameterisation"),
}
MAX_SEED = 2**63 - 1


@pytest.mark.parametrize("mode", list(GenerationMode))
def test_no_request_ends_in_a_fault(
    service: Any, document: Any, sizes: Any, beam: str, rig: str, mode: Any
) -> None:
    faults: list[str] = []
    schema = schemathesis.openapi.from_dict(document)
    known = {"id": beam, "structure_id": beam, "rig_id": rig}

    def send(case: Any) -> None:
        if isinstance(case.body, dict):  # ids that exist lead further than made-up ones
            case.body.update({name: id for name, id in known.items() if name in case.body})
        if mode is GenerationMode.POSITIVE and case.path.endswith("/changes"):
            case.body = on_the_structure(case.body, sizes)
        # what others need is not deleted
        if mode is GenerationMode.POSITIVE and "id" in case.path_parameters and case.method != "DELETE":
            case.path_parameters["id"] = known["rig_id" if "/rigs" in case.path else "id"]
        call = case.as_transport_kwargs(base_url="http://localhost:8000")
        call = {name: value for name, value in call.items() if name != "cookies" and value is not None}
        reply = service.request(call.pop("method"), call.pop("url"), **_for_httpx(call))
        wrong = reply.status_code >= 500 or reply.status_code == 405
        if mode is GenerationMode.POSITIVE and case.method == "POST":
            wrong = wrong or refused_without_reason(case.path, reply)
        if wrong:
            faults.append(f"{case.as_curl_command()} -> {reply.status_code} {reply.text[:300]}")

    for result in schema.get_all_operations():
        operation: Any = result.ok()  # type: ignore[union-attr]
        with suppress(Unsatisfiable):  # nothing about a request without parameters can be wrong
            CHECKED(given(case=operation.as_strategy(generation_mode=mode))(send))()
    assert not faults, "\n".join(faults)


def on_the_structure(body: Any, sizes: Any) -> Any:
    """Return a body of changes at nodes and members that the structure has, whatever their numbers were."""
    changes = [
        change
        | ({"node": change["node"] % sizes["n_nodes"] + 1} if "node" in change else {})
        | (
            {"members": [number % sizes["members"] + 1 for number in change["members"]]}
            if "members" in change
            else {}
        )
        for change in body["changes"]
    ]
    return body | {"changes": changes}


def refused_without_reason(path: str, reply: Any) -> bool:
    """Return whether a request that the schema allows was refused for its form or for a single value."""
    if reply.status_code not in (400, 415, 422):
        return False
    problem = reply.json()
    if problem["code"] in ("structure", "unknown_dof"):  # rules between nodes, members and supports
        return False
    field, value = (problem["context"].get(name, "") for name in ("field", "value"))
    if isinstance(value, int) and value > MAX_SEED:  # the generator rounds the bound to a power of two
        return False
    # parameters and places of an effect depend on its kind
    return (path, field) not in BEYOND_A_SCHEMA and not field.startswith(("effects.", "at"))


@pytest.mark.parametrize("method", ["GET", "POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE"])
def test_a_method_that_a_path_does_not_take_is_405_with_those_it_takes(
    service: Any, document: Any, method: str
) -> None:
    for path, methods in document["paths"].items():
        if method.lower() not in methods:
            reply = service.request(method, path.replace("{family}", "effects").replace("{id}", "5f0c31"))
            allowed = ", ".join(sorted(name.upper() for name in methods))
            assert (reply.status_code, reply.headers.get("allow")) == (405, allowed), (method, path)


def _for_httpx(call: dict[str, Any]) -> dict[str, Any]:
    """Return the arguments of a call as httpx names them: raw bytes are content."""
    if isinstance(call.get("data"), (bytes, str)):
        call["content"] = call.pop("data")
    return call
