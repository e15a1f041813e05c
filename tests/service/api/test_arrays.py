"""Arrays as npz and as JSON, tables as CSV: the same figures, by the schema of the document."""

import csv
import io
from dataclasses import replace
from typing import Any

import jsonschema_rs
import numpy as np
import pytest
from starlette.datastructures import Headers

from modallab.api import arrays
from modallab.api.limits import REPLY
from modallab.api.media import JSON_TYPE, accepts


@pytest.fixture(scope="module")
def test(service: Any, beam: str, rig: str) -> str:
    """A measurement of the beam."""
    return str(service.result_of("/v1/measurements", {"structure_id": beam, "rig_id": rig, "route": "drawn"}))


@pytest.fixture(scope="module")
def modes(service: Any, test: str) -> str:
    """Modes read from it."""
    return str(service.result_of("/v1/modal-models", {"measurement_id": test, "n_modes": 3}))


PATHS = [
    "/v1/structures/{beam}/modes/arrays?count=3",
    "/v1/structures/{beam}/frf?drive=1:%2BY&responses=7:%2BY&kind=receptance&n_lines=21",
    "/v1/structures/{beam}/reduced?masters=1:%2BY&masters=11:%2BY&masters=21:%2BY",
    "/v1/measurements/{test}/arrays",
    "/v1/measurements/{test}/arrays?kind=mobility",
    "/v1/modal-models/{modes}/arrays",
    "/v1/modal-models/{modes}/frf",
]


def template(document: Any, path: str) -> Any:
    """Return the JSON schema of a reply, its references resolved in the document."""
    for address, methods in document["paths"].items():
        pattern = path.split("?")[0]
        for name in ("beam", "test", "modes"):
            pattern = pattern.replace(f"{{{name}}}", "{id}")
        if address == pattern:
            schema = methods["get"]["responses"]["200"]["content"][JSON_TYPE]["schema"]
            return schema | {"components": document["components"]}
    raise KeyError(path)


@pytest.mark.parametrize("path", PATHS)
def test_json_has_the_figures_of_the_npz_and_the_form_of_its_schema(
    service: Any, beam: str, test: str, modes: str, path: str
) -> None:
    address = path.format(beam=beam, test=test, modes=modes)
    binary = service.request("GET", address)
    assert binary.headers["content-type"] == "application/octet-stream"
    reply = service.request("GET", address, headers={"accept": "application/json"})
    assert reply.headers["content-type"] == "application/json"
    body = reply.json()
    jsonschema_rs.validate(template(service.get("/openapi.json"), path), body)
    arrays = np.load(io.BytesIO(binary.content))
    assert set(arrays) == set(body)
    for name in arrays:
        values = np.array(body[name])
        if arrays[name].dtype.kind == "c":
            values = values.astype(float)  # null to NaN
            values = values[..., 0] + 1j * values[..., 1]
        if arrays[name].dtype.kind == "f":
            np.testing.assert_array_equal(values.astype(float), arrays[name])
        else:
            np.testing.assert_array_equal(values, arrays[name])


def test_precision_goes_with_the_arrays_of_a_query_with_several_parameters(service: Any, beam: str) -> None:
    path = f"/v1/structures/{beam}/frf?drive=1:%2BY&responses=7:%2BY&n_lines=21&precision=single"
    arrays = np.load(io.BytesIO(service.request("GET", path).content))
    assert arrays["values"].dtype == np.complex64


@pytest.mark.parametrize(
    ("accept", "preferred"),
    [
        ("*/*", False),
        ("", False),
        ("application/json", True),
        ("application/json, text/plain, */*", True),
        ("application/octet-stream, application/json;q=0.5", False),
        ("application/octet-stream;q=0.5, application/json", True),
        ("application/json;q=0", False),
        ("application/json;q=high", False),
    ],
)
def test_json_is_sent_where_it_is_named_and_preferred(accept: str, preferred: bool) -> None:
    headers = Headers({"accept": accept})
    assert accepts(headers, JSON_TYPE, "application/octet-stream") is preferred


def table(service: Any, path: str) -> list[dict[str, str]]:
    """Return the rows of a reply as CSV."""
    reply = service.request("GET", path, headers={"accept": "text/csv"})
    assert reply.headers["content-type"].startswith("text/csv")
    return list(csv.DictReader(io.StringIO(reply.text)))


def test_modes_come_as_a_table(service: Any, beam: str, modes: str) -> None:
    rows = table(service, f"/v1/modal-models/{modes}")
    listed = service.get(f"/v1/modal-models/{modes}")["modes"]
    assert [float(row["frequency"]) for row in rows] == [mode["frequency"] for mode in listed]
    assert [float(row["frequency_spread_sd"]) for row in rows] == [
        mode["frequency_spread"]["sd"] for mode in listed
    ]
    rows = table(service, f"/v1/structures/{beam}/modes?count=3")
    frequencies = service.get(f"/v1/structures/{beam}/modes?count=3")["frequencies"]
    assert [float(row["frequency"]) for row in rows] == frequencies


def test_arrays_too_large_for_json_are_refused_with_the_type_to_ask_for(
    service: Any, test: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(arrays, "REPLY", replace(REPLY, json_array_values=100))
    reply = service.request("GET", f"/v1/measurements/{test}/arrays", headers={"accept": "application/json"})
    assert (reply.status_code, reply.json()["context"]["field"]) == (422, "Accept")
    assert reply.json()["context"]["allowed"] == "application/octet-stream"
