"""Jobs that would take too long are refused when they are asked for."""

from typing import Any

import pytest

from modallab.api.settings import ServiceSettings
from tests.faults.heavy import plate

RIG = {"drive": "1:+Y", "responses": [f"{n}:+Y" for n in range(1, 22)]}
LIMIT = 60.0  # s


@pytest.fixture(scope="module")
def settings(tmp_path_factory: pytest.TempPathFactory) -> ServiceSettings:
    """Settings of a service whose jobs are short."""
    return ServiceSettings(data=tmp_path_factory.mktemp("data"), job_seconds=LIMIT)


def refusal(service: Any, path: str, body: dict[str, Any]) -> Any:
    reply = service.request("POST", path, json=body)
    assert reply.status_code == 422, reply.text
    context = reply.json()["context"]
    assert context["limit"] == LIMIT < context["estimate"]
    return context


def test_a_test_of_hours_is_refused(service: Any, beam: str) -> None:
    analyser = {"frequency_max": 800.0, "n_lines": 90_001, "averages": 100_000}
    rig = service.post("/v1/rigs", RIG | {"analyser": analyser})["id"]
    body = {"structure_id": beam, "rig_id": rig, "route": "sampled", "seed": 1}
    context = refusal(service, "/v1/measurements", body)
    assert (context["field"], context["value"]) == ("averages", 100_000)
    assert 100 < context["allowed"]["maximum"] < 1000  # 0.2 s an average
    service.post("/v1/measurements", body | {"route": "expected"}, status=202)  # no record is made


def test_tests_and_extractions_of_a_class_are_short_and_diagnoses_long(service: Any, beam: str) -> None:
    rig = service.post("/v1/rigs", RIG | {"noise": {"force": 1e-3, "response": 1e-3}})["id"]
    body = {"structure_id": beam, "rig_id": rig, "route": "sampled", "seed": 1}
    test = service.post("/v1/measurements", body, status=202)
    of_test = {"measurement_id": test["result_id"]}
    extraction = service.post("/v1/modal-models", of_test, status=202)
    assert (test["lane"], extraction["lane"]) == ("short", "short")
    diagnosis = service.post("/v1/diagnoses", of_test | {"structure_id": beam, "max_effects": 1}, status=202)
    assert diagnosis["lane"] == "long"
    wide = service.post("/v1/rigs", RIG | {"analyser": {"n_lines": 12_801, "averages": 500}})["id"]
    long = service.post("/v1/measurements", body | {"rig_id": wide}, status=202)
    assert long["lane"] == "long"  # 500 averages x 32,768 samples x 22 channels


def test_work_on_a_large_model_is_refused(service: Any) -> None:
    large = service.post("/v1/structures", plate(24))["id"]
    synthetic = {"count": 3, "dofs": ["30:+Z", "40:+Z"]}
    modes = service.post(f"/v1/structures/{large}/synthetic-modes", synthetic)["id"]
    update = {"structure_id": large, "modal_model_id": modes, "parameterisation": {"macros": [[1, 2]]}}
    context = refusal(service, "/v1/updates", update | {"options": {"max_iterations": 1000}})
    assert context["field"] == "max_iterations"
    study = {"structure_id": large, "truth_id": large, "divisions": {"two": [[1, 2]]}, "dofs": ["30:+Z"]}
    many = {"seeds": list(range(50)), "method": "inverse_eigensensitivity"}
    assert refusal(service, "/v1/studies", study | many)["field"] == "seeds"
    rig = service.post("/v1/rigs", {"drive": "30:+Z", "responses": ["30:+Z", "40:+Z"]})["id"]
    test = service.result_of(
        "/v1/measurements", {"structure_id": large, "rig_id": rig, "route": "expected", "seed": 1}
    )
    diagnosis = refusal(service, "/v1/diagnoses", {"structure_id": large, "measurement_id": test})
    assert diagnosis["field"] == "structure_id"
