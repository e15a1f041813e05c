"""Updates from complex modes over HTTP."""

from typing import Any

import numpy as np
import pytest

SENSORS = [f"{n}:+Y" for n in range(1, 22, 2)]
FOURS = [list(range(first, first + 4)) for first in range(1, 21, 4)]
METHOD = "complex_inverse_eigensensitivity"


@pytest.fixture(scope="module")
def lossy(service: Any, beam: str) -> str:
    """Modes of the beam with two stiffer members that lose energy."""
    changes = [
        {"members": [11, 12], "property": "modulus", "factor": 1.5},
        {"members": [11, 12], "property": "loss_factor", "value": 0.3},
    ]
    truth = service.post(f"/v1/structures/{beam}/changes", {"changes": changes})["id"]
    return modes(service, truth)


def modes(service: Any, structure: str) -> str:
    body = {"count": 8, "dofs": SENSORS}
    return str(service.post(f"/v1/structures/{structure}/synthetic-modes", body)["id"])


def asked(beam: str, modes: str, method: str, **parameterisation: Any) -> dict[str, Any]:
    parameters = {"macros": FOURS} | parameterisation
    return {"structure_id": beam, "modal_model_id": modes, "method": method, "parameterisation": parameters}


def test_damping_is_found_beside_stiffness_where_no_parts_are_named(
    service: Any, beam: str, lossy: str
) -> None:
    found = service.get(f"/v1/updates/{service.result_of('/v1/updates', asked(beam, lossy, METHOD))}")
    assert found["converged"]
    assert set(found["coefficients"]) == {"mass", "stiffness", "damping"}
    damping = {int(n): value for n, value in found["coefficients"]["damping"].items()}
    # 0.005 of it is what the whole beam has, and stays; exact modes, so that rounding is left
    expected = [0.295 if n in (11, 12) else 0.0 for n in range(1, 21)]
    np.testing.assert_allclose([damping[n] for n in range(1, 21)], expected, atol=1e-6)
    assert set(found["suspected"]["damping"]) >= {11, 12}
    shown = service.get(f"/v1/structures/{found['structure_id']}/modes", params={"count": 8})
    measured = service.get(f"/v1/modal-models/{lossy}")["modes"]
    np.testing.assert_allclose(shown["loss_factors"], [one["loss_factor"] for one in measured], rtol=1e-6)


def test_the_catalogue_has_the_method_and_what_it_may_be_told(service: Any) -> None:
    listed = {one["kind"]: one for one in service.get("/v1/catalog/updating-methods")}
    assert "complex modes" in listed[METHOD]["summary"]
    assert listed[METHOD]["parameters"]["damping_threshold"]["default"] == 0.008
    assert "damping_threshold" not in listed["inverse_eigensensitivity"]["parameters"]


@pytest.mark.parametrize("method", ["inverse_eigensensitivity", "zhang_sensitivity"])
def test_damping_is_not_asked_of_a_method_of_real_modes(
    service: Any, beam: str, lossy: str, method: str
) -> None:
    wrong = service.post("/v1/updates", asked(beam, lossy, method, parts=["mass", "damping"]), status=422)
    assert wrong["code"] == "invalid_input"
    assert wrong["context"]["field"] == "parts"
    assert wrong["context"]["value"] == "damping"


def test_a_threshold_of_damping_is_no_option_of_a_method_of_real_modes(
    service: Any, beam: str, lossy: str
) -> None:
    body = asked(beam, lossy, "inverse_eigensensitivity") | {"options": {"damping_threshold": 0.1}}
    assert service.post("/v1/updates", body, status=422)["context"]["field"] == "damping_threshold"


REAL, LAGGING = [1.0, -0.5, 1.0], [[1.0, 0.0], [-0.5, 0.4], [1.0, 0.0]]


@pytest.mark.parametrize(
    ("method", "shape", "field", "said"),
    [
        (METHOD, REAL, "loss_factors", "modes are real"),
        ("inverse_eigensensitivity", LAGGING, "modes", "is complex"),
        ("zhang_subspace", LAGGING, "modes", "is complex"),
    ],
)
def test_modes_of_the_wrong_kind_fail_the_job_by_name(
    service: Any, beam: str, method: str, shape: Any, field: str, said: str
) -> None:
    mode = {"frequency": 23.6, "loss_factor": 0.0, "shape": shape}
    body = {"modes": [mode], "dofs": ["1:+Y", "11:+Y", "21:+Y"], "normalisation": "none"}
    given = str(service.post("/v1/modal-models/import", body)["id"])
    asking = asked(beam, given, method, parts=["stiffness"], macros=[[1, 2]])
    job = service.get(f"/v1/jobs/{service.post('/v1/updates', asking, status=202)['id']}")
    assert job["state"] == "failed"
    assert (job["error"]["status"], job["error"]["code"]) == (422, "invalid_input")
    assert job["error"]["context"]["field"] == field
    assert said in job["error"]["detail"]
