"""The page of a diagnosis: what it says of itself."""

import html
import json
import re

from tests.bodies import free_beam
from tests.service.api.conftest import Service

BODY = free_beam()
RIG = {
    "drive": "1:+Y",
    "responses": [f"{n}:+Y" for n in (1, 2, 4, 5, 7, 9)],
    "noise": {"force": 1e-4, "response": 1e-4},
    "analyser": {"frequency_max": 400.0, "n_lines": 161},
}
MASS = {"kind": "extra_mass", "at": "4:+Y", "parameters": {"mass": 0.03}}


def test_the_call_that_a_page_names_gives_the_same_diagnosis_again(service: Service) -> None:
    beam, log_book = service.post("/v1/structures", BODY)["id"], service.post("/v1/rigs", RIG)["id"]
    test = {"structure_id": beam, "rig_id": log_book, "effects": [MASS], "route": "drawn", "seed": 1}
    asked = {
        "structure_id": beam,
        "measurement_id": service.result_of("/v1/measurements", test),
        "suspects": ["extra_mass", "gain_error"],
        "hold_out": {"fraction": 0.4, "dofs": ["3:+Y"]},
        "max_effects": 2,
        "seed": 7,
    }
    first = service.result_of("/v1/diagnoses", asked)
    page = service.request("GET", f"/v1/diagnoses/{first}/report").text
    call = re.search(r'<div class="call">POST /v1/diagnoses\n(.*?)</div>', page, flags=re.DOTALL)
    assert call is not None
    named = json.loads(html.unescape(call[1]))
    assert named == asked
    found, again = (
        service.get(f"/v1/diagnoses/{id}") for id in (first, service.result_of("/v1/diagnoses", named))
    )
    assert again["steps"] == found["steps"]
    assert found["version"] in page
    assert first in page
