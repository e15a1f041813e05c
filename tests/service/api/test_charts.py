"""Stabilisation charts over HTTP."""

from typing import Any

import numpy as np
import pytest

RESPONSE = "9:+Y"


@pytest.fixture(scope="module")
def charted(service: Any, beam: str, rig: str) -> str:
    """Modes of a test with 0.1 % noise, by a method that finds all of them at once."""
    body = {"structure_id": beam, "rig_id": rig, "route": "drawn"}
    asked = {"measurement_id": service.result_of("/v1/measurements", body), "method": "lscf", "n_modes": 8}
    return str(service.result_of("/v1/modal-models", asked))


def test_a_global_method_has_a_chart_and_no_single_fits(service: Any, charted: str) -> None:
    refused = service.request(
        "GET", f"/v1/modal-models/{charted}/fits", params={"mode": 1, "response": RESPONSE}
    )
    assert (refused.status_code, refused.json()["context"]["field"]) == (422, "method")
    chart = service.get(f"/v1/modal-models/{charted}/chart", params={"points": 200})
    lengths = {len(chart[name]) for name in ("order", "frequency", "loss_factor", "stability", "mode")}
    assert len(lengths) == 1
    assert set(chart["stability"]) <= {0, 1, 2, 3}
    assert chart["modes"] == [
        mode["frequency"] for mode in service.get(f"/v1/modal-models/{charted}")["modes"]
    ]
    frequency = np.array(chart["frequency"])
    for number, known in enumerate(chart["modes"], 1):
        column = frequency[[mode == number for mode in chart["mode"]]]
        assert len(column) >= 3  # orders that agree
        assert np.median(column) == pytest.approx(known, rel=1e-3)
