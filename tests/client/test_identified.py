"""What data say of coefficients, as the client asks for it and reads it."""

from typing import Any

import numpy as np

from modallab_client import ModalLab
from modallab_client._read import read_as
from modallab_client.methods.updates import update_of
from modallab_client.results import IterativeUpdate, MacroElement, ResponseBasedUpdate
from tests.client.fake import UPDATE, FakeService, npz

WORDS = "mass and stiffness of 11 can hardly be told apart by these data"
MACROS = [{"part": part, "members": [11]} for part in ("mass", "stiffness")]
AT_ONCE: dict[str, Any] = UPDATE | {
    "coefficients": {"stiffness": {"11": 2.0, "12": 1.0}},
    "standard_errors": {"stiffness": {"11": 0.01}},
    "intervals": {"stiffness": {"11": [1.6, 2.5], "12": [0.8, 1.3]}},
    "identifiability": {
        "rank": 2,
        "condition_number": 12.0,
        "singular_values": [12.0, 1.0],
        "macros": [*MACROS, {"part": "stiffness", "members": [12]}],
        "unidentified": MACROS[:1],
        "directions": [
            {"words": WORDS, "standard_error": 0.44, "macros": MACROS, "shares": [0.7, 0.7]},
        ],
    },
}


def test_intervals_and_directions_are_read() -> None:
    update = update_of(AT_ONCE)
    assert isinstance(update, IterativeUpdate)
    assert update.intervals["stiffness"][11] == (1.6, 2.5)
    assert update.identifiability is not None
    assert update.identifiability.unidentified == (MacroElement(part="mass", members=(11,)),)
    (direction,) = update.identifiability.directions
    assert str(direction) == f"{WORDS} (standard error 0.44)"
    assert [macro.part for macro in direction.macros] == ["mass", "stiffness"]
    np.testing.assert_array_equal(direction.shares, [0.7, 0.7])
    assert "1.6 to 2.5" in update.table()


def test_properties_are_read_in_their_units() -> None:
    given = {"part": "thickness", "members": [3, 4], "unit": "m", "before": 0.004, "after": 0.005}
    known, open_ = (
        read_as(IterativeUpdate, UPDATE | {"quantities": [given | {"interval": interval}]}).quantities[0]
        for interval in ([0.0049, 0.0051], None)
    )
    assert (known.members, known.interval, open_.interval) == ((3, 4), (0.0049, 0.0051), None)
    assert str(known) == "thickness of 3, 4: 0.005 m, was 0.004 (95 %: 0.0049 to 0.0051)"
    assert str(open_) == "thickness of 3, 4: 0.005 m, was 0.004"
    assert read_as(IterativeUpdate, UPDATE).quantities == ()


def test_an_update_without_them_is_read_too() -> None:
    update = read_as(IterativeUpdate, UPDATE)
    assert update.intervals == {}
    assert update.identifiability is None
    assert " to " not in update.table()


def test_a_prior_is_asked_for_by_keyword_and_the_covariance_comes_apart(
    lab: ModalLab, service: FakeService
) -> None:
    service.on("POST /v1/updates", {"id": "j1", "state": "queued"})
    covariance = npz(
        coefficients=np.array(["mass of 11"]), intervals=np.array([[0.9, 1.1]]), covariance=np.eye(1)
    )
    service.on("GET /v1/updates/u1/covariance", covariance)
    lab.updates.start(
        "s1", "mm1", method="one_shot", macros="each", prior="common", underdetermined="regularised"
    )
    assert service.body(0)["options"] == {"prior": "common", "underdetermined": "regularised"}
    assert service.body(0)["parameterisation"] == {"macros": "each"}
    found = lab.updates.covariance("u1")
    assert found.coefficients == ("mass of 11",)
    np.testing.assert_array_equal(found.covariance, np.eye(1))


def test_an_update_on_responses_is_asked_for_and_read(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/updates", {"id": "j1", "state": "queued"})
    lab.updates.start("s1", measurement_id="m1", method="frf_residual", noise_floor=0.01)
    body = service.body(0)
    assert (body["measurement_id"], body["noise_floor"]) == ("m1", 0.01)
    assert "modal_model_id" not in body
    fit = {
        "before": 900.0,
        "after": 1.02,
        "scatter": 0.03,
        "n_lines": 160,
        "band": [10.0, 1600.0],
        "n_held_out": 0,
        "held_out_before": None,
        "held_out_after": None,
        "outputs": ["1:+Y", "3:+Y"],
        "inputs": ["1:+Y"],
        "by_frf_before": [[800.0], [1000.0]],
        "by_frf_after": [[1.0], [1.04]],
    }
    update = update_of(UPDATE | {"kind": "response_based", "responses": fit})
    assert isinstance(update, ResponseBasedUpdate)
    read = update.responses
    assert read.by_frf_after.shape == (2, 1)
    assert str(read) == "mean square of 160 lines: 1.02, was 900; 1 +- 0.03 by random error alone"
    assert "1.99" in update.table()
