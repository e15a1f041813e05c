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


def test_doubtful_poles_stand_in_the_chart_as_in_the_model(service: Any, charted: str) -> None:
    chart = service.get(f"/v1/modal-models/{charted}/chart")
    assert chart["doubtful"] == service.get(f"/v1/modal-models/{charted}")["doubtful"]


def test_flags_and_notes_are_counted_unless_all_are_asked_for(service: Any, charted: str) -> None:
    path = f"/v1/modal-models/{charted}"
    brief = service.get(path)
    full = service.get(path, params={"details": ["flags", "notes"]})
    assert brief["flag_counts"] == full["flag_counts"]
    assert sum(brief["flag_counts"].values()) == sum(len(mode["flags"]) for mode in full["modes"])
    for short, complete in zip(brief["modes"], full["modes"], strict=True):
        assert sum(short["flag_counts"].values()) == len(complete["flags"])
        assert len(short["flags"]) <= len(complete["flags"])
        assert bool(short["flags"]) == bool(complete["flags"])
    assert len(brief["notes"]) < len(full["notes"])  # a reason for each of eight modes
    assert len(brief["main_flags"]) <= 3
    assert service.request("GET", path, params={"details": "colours"}).status_code == 422
    table = service.request("GET", path, params={"details": "flags"}, headers={"accept": "text/csv"}).text
    assert all(flag in table for mode in full["modes"] for flag in mode["flags"] if '"' not in flag)


def test_the_misfit_is_that_of_the_extracted_range(service: Any, beam: str, rig: str) -> None:
    body = {"structure_id": beam, "rig_id": rig, "route": "drawn"}
    measured = service.result_of("/v1/measurements", body)
    asked = {"measurement_id": measured, "method": "lscf", "bands": [[50.0, 250.0]]}
    model = service.get(f"/v1/modal-models/{service.result_of('/v1/modal-models', asked)}")
    assert model["ranges"] == [[50.0, 250.0]]
    assert len(model["modes"]) == 3
    # five modes outside the range are larger than the random error of 1e-3 there, and are not its misfit
    assert max(model["resynthesis_error"].values()) < 0.02
