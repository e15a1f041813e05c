"""What an extraction looks like over HTTP: fits, charts, resynthesised FRFs, indicators, reciprocity."""

import io
from typing import Any

import numpy as np
import pytest

MODE, RESPONSE = 3, "9:+Y"
EXACT = ["circle_fit", "dobson", "line_fit", "linear_fit"]
SINGLE = [*EXACT, "peak_picking"]


def npz(service: Any, path: str, **params: Any) -> Any:
    reply = service.request("GET", path, params=params)
    assert reply.status_code == 200, reply.text
    return np.load(io.BytesIO(reply.content))


def complex_of(pairs: Any) -> Any:
    given = np.array(pairs, dtype=float)
    return given[..., 0] + 1j * given[..., 1]


@pytest.fixture(scope="module")
def measured(service: Any, beam: str, rig: str) -> str:
    """A test with 0.1 % noise."""
    body = {"structure_id": beam, "rig_id": rig, "route": "drawn"}
    return str(service.result_of("/v1/measurements", body))


@pytest.fixture(scope="module")
def models(service: Any, measured: str) -> dict[str, str]:
    """The same modes by every method."""
    body = {"measurement_id": measured, "n_modes": 8}
    return {
        method: str(service.result_of("/v1/modal-models", body | {"method": method})) for method in SINGLE
    }


def fit(service: Any, id: str, mode: int = MODE, response: str = RESPONSE) -> Any:
    return service.get(f"/v1/modal-models/{id}/fits", params={"mode": mode, "response": response})


@pytest.mark.parametrize("method", SINGLE)
def test_a_fit_is_that_of_the_model(service: Any, models: dict[str, str], method: str) -> None:
    drawn = fit(service, models[method])
    held = npz(service, f"/v1/modal-models/{models[method]}/arrays")
    row = held["dofs"].tolist().index(RESPONSE)
    assert (drawn["mode"], drawn["response"], drawn["method"]) == (MODE, RESPONSE, method)
    # the neighbours were still moving in the last round of the model: second order of the first guess
    assert drawn["frequency"] == pytest.approx(held["fitted_frequency"][MODE - 1, row], rel=1e-6)
    assert drawn["loss_factor"] == pytest.approx(held["fitted_loss_factor"][MODE - 1, row], rel=1e-3)
    assert complex_of(drawn["modal_constant"]) == pytest.approx(
        held["modal_constants"][MODE - 1, row], rel=1e-3
    )


@pytest.mark.parametrize("method", EXACT)
def test_the_curve_runs_through_the_cleaned_lines(service: Any, models: dict[str, str], method: str) -> None:
    drawn = fit(service, models[method])
    cleaned, curve = complex_of(drawn["cleaned"]), complex_of(drawn["curve"])
    at = [np.interp(drawn["freq"], drawn["curve_freq"], part) for part in (curve.real, curve.imag)]
    # noise is 1e-4 of a line; straight lines between 201 points of a sharp peak are within a hundredth
    np.testing.assert_allclose(at[0] + 1j * at[1], cleaned, atol=0.01 * np.abs(cleaned).max())
    assert len(drawn["measured"]) == len(drawn["freq"]) == len(drawn["used"])


def test_a_circle_fit_shows_circle_points_and_damping_of_all_pairs(
    service: Any, models: dict[str, str]
) -> None:
    drawn = fit(service, models["circle_fit"])
    real, turning = drawn["details"], {n: complex_of(v) for n, v in drawn["complex_details"].items()}
    radius = np.ravel(real["radius"])[0]
    np.testing.assert_allclose(np.abs(turning["circle"] - turning["centre"]), radius, rtol=1e-12)
    # the noise of a line, 1e-4 of it, and what neighbours leave
    np.testing.assert_allclose(np.abs(turning["points"] - turning["centre"]), radius, rtol=5e-3)
    assert 0 < drawn["quality"]["radius_variation"] < 0.5  # %
    surface = np.array(real["damping_surface"])
    assert surface.shape == (len(real["x_above"]), len(real["x_below"]))
    assert np.median(surface) == pytest.approx(drawn["loss_factor"], rel=0.02)


def test_straight_lines_are_straight(service: Any, measured: str, models: dict[str, str]) -> None:
    drawn = fit(service, models["line_fit"])
    inverse, line = (complex_of(drawn["complex_details"][name]) for name in ("inverse", "line"))
    test = npz(service, f"/v1/measurements/{measured}/arrays")
    row = np.searchsorted(test["freq"], np.array(drawn["freq"]) - 1e-9)
    seen = test["coherence"][row, test["outputs"].tolist().index(RESPONSE)]
    noise = np.sqrt((1 - seen) / seen / test["averages"]) * np.abs(complex_of(drawn["measured"]))
    off = np.abs((inverse - line) / inverse) * np.abs(complex_of(drawn["cleaned"])) / noise
    # a complex normal number is beyond three times its root mean square once in 8,000; eight squares, of
    # which the fit takes two, have a mean of 3/4, and beyond 1.5 once in 100
    assert (off < 3).all()
    assert (off**2).mean() < 1.5
    bend = np.diff(line) / np.diff(drawn["details"]["x"])
    np.testing.assert_allclose(bend, bend[0], rtol=1e-6)  # rounding of differences


def test_a_wide_window_is_drawn_by_some_of_its_quotients(service: Any, measured: str) -> None:
    body = {"measurement_id": measured, "n_modes": 3, "bands": [[100.0, 250.0]], "options": {"lines": 70}}
    drawn = fit(service, service.result_of("/v1/modal-models", body), mode=1)
    assert len(drawn["freq"]) == 70
    delta = complex_of(drawn["complex_details"]["delta"])
    assert delta.shape == (40, 69)
    assert np.shape(drawn["details"]["x_delta"]) == delta.shape
    assert np.shape(drawn["details"]["x"]) == (70,)


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "mode 0": ({"mode": 0, "response": RESPONSE}, "query.mode"),
    "a mode too many": ({"mode": 9, "response": RESPONSE}, "mode"),
    "no such response": ({"mode": 1, "response": "2:+Y"}, "response"),
    "no degree of freedom": ({"mode": 1, "response": "here"}, "response"),
    "no response": ({"mode": 1}, "query.response"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_fit_that_is_not_there_is_refused_by_name(service: Any, models: dict[str, str], case: str) -> None:
    params, field = WRONG[case]
    reply = service.request("GET", f"/v1/modal-models/{models['dobson']}/fits", params=params)
    assert reply.status_code == 422
    assert reply.json()["context"]["field"] == field


def test_a_method_without_chart_says_so(service: Any, models: dict[str, str]) -> None:
    reply = service.request("GET", f"/v1/modal-models/{models['dobson']}/chart")
    assert (reply.status_code, reply.json()["code"]) == (404, "not_found")
    assert "lscf" in reply.json()["context"]["allowed"]


def test_modes_from_elsewhere_have_nothing_to_draw(service: Any) -> None:
    modes = [{"frequency": 20.0, "shape": [1, 1]}]
    id = service.post("/v1/modal-models/import", {"modes": modes, "dofs": ["1:+Y", "2:+Y"]})["id"]
    for path, params in (("fits", {"mode": 1, "response": "1:+Y"}), ("chart", {}), ("frf", {})):
        reply = service.request("GET", f"/v1/modal-models/{id}/{path}", params=params)
        assert reply.status_code == 422, path
        assert "not read from a measurement" in reply.json()["detail"]


@pytest.mark.parametrize("kind", [None, "receptance"])
def test_modes_make_the_measured_frfs_again(
    service: Any, models: dict[str, str], measured: str, kind: str | None
) -> None:
    asked = {} if kind is None else {"kind": kind}
    made = npz(service, f"/v1/modal-models/{models['dobson']}/frf", **asked)
    test = npz(service, f"/v1/measurements/{measured}/arrays", **asked)
    for name in ("freq", "outputs", "inputs", "kind"):
        np.testing.assert_array_equal(made[name], test[name])
    above = (test["freq"] > 30) & (test["freq"] < 700)
    left = np.abs(made["values"] - test["values"])[above]
    whole = np.sqrt((np.abs(test["values"][above]) ** 2).mean(axis=0))
    # modal constants of modes narrower than a line are known to percents, and as receptance the first
    # mode's flank outweighs all else
    assert (np.sqrt((left**2).mean(axis=0)) < 0.05 * whole).all()


def test_a_roving_hammer_gets_its_frfs_by_drive_point(service: Any, beam: str) -> None:
    rig = {"drives": [f"{n}:+Y" for n in (1, 5, 9)], "responses": ["1:+Y"], "exciter": {"kind": "hammer"}}
    rig_id = service.post("/v1/rigs", rig)["id"]
    body = {"structure_id": beam, "rig_id": rig_id, "route": "expected"}
    measured = service.result_of("/v1/measurements", body)
    id = service.result_of("/v1/modal-models", {"measurement_id": measured, "n_modes": 4})
    made, test = (
        npz(service, f"/v1/modal-models/{id}/frf"),
        npz(service, f"/v1/measurements/{measured}/arrays"),
    )
    assert made["values"].shape == test["values"].shape == (401, 1, 3)
    assert made["inputs"].tolist() == test["inputs"].tolist()
    assert fit(service, id, mode=2, response="5:+Y")["response"] == "5:+Y"


def test_the_loss_factor_an_exponential_window_adds_is_in_the_picture(service: Any, beam: str) -> None:
    analyser = {"window": "force_exponential", "excitation": {"kind": "impact"}}
    rig = {"drives": ["1:+Y"], "responses": ["1:+Y"], "exciter": {"kind": "hammer"}, "analyser": analyser}
    rig_id = service.post("/v1/rigs", rig)["id"]
    measured = service.result_of(
        "/v1/measurements", {"structure_id": beam, "rig_id": rig_id, "route": "expected"}
    )
    body = {"measurement_id": measured, "n_modes": 4}
    seen, true = (
        service.result_of("/v1/modal-models", body | {"correct_window_damping": on}) for on in (False, True)
    )
    pictures = [fit(service, id, mode=2, response="1:+Y") for id in (seen, true)]
    losses = [service.get(f"/v1/modal-models/{id}")["modes"][1]["loss_factor"] for id in (seen, true)]
    assert losses[1] < 0.9 * losses[0]
    # the lines are the same, whatever is taken off afterwards
    assert pictures[1]["loss_factor"] == pytest.approx(pictures[0]["loss_factor"], rel=1e-9)
    made = [npz(service, f"/v1/modal-models/{id}/frf")["values"] for id in (seen, true)]
    np.testing.assert_allclose(made[1], made[0], rtol=1e-9)


def test_indicators_show_every_mode(service: Any) -> None:
    body = {
        "kind": "beam",
        "length": 1.5,
        "n_elements": 20,
        "section": {"area": 5e-4, "second_moment": 4.1667e-9},
        "material": {"modulus": 2.09e11, "density": 7800.0},
        "damping": {"law": "structural", "stiffness_coefficient": 0.02},
    }
    beam = service.post("/v1/structures", body)["id"]
    analyser = {"frequency_max": 400.0, "n_lines": 1601}
    rig = {"drive": "1:+Y", "responses": ["1:+Y", "9:+Y", "21:+Y"], "analyser": analyser}
    rig_id = service.post("/v1/rigs", rig)["id"]
    test = service.result_of(
        "/v1/measurements", {"structure_id": beam, "rig_id": rig_id, "route": "expected"}
    )
    shown = service.get(f"/v1/measurements/{test}/indicators", params={"points": 1600})
    freq, mif, cmif = np.array(shown["freq"]), np.array(shown["mif"]), np.array(shown["cmif"])
    assert shown["inputs"] == ["1:+Y"]
    assert mif.shape == cmif.shape == (1, 1600)
    for known in service.get(f"/v1/structures/{beam}/modes", params={"count": 5})["frequencies"]:
        near = np.abs(freq - known) < 2.0  # Hz: eight lines to either side
        # half-power bandwidths are 2 lines or more, so that a line is within a quarter of one
        assert mif[0, near].min() < 0.5
        assert abs(freq[near][mif[0, near].argmin()] - known) <= 0.25
        assert abs(freq[near][cmif[0, near].argmax()] - known) <= 0.25
    few = service.get(f"/v1/measurements/{test}/indicators", params={"points": 60})
    assert len(few["freq"]) <= 124
    assert freq[cmif[0].argmax()] in few["freq"]
    assert freq[mif[0].argmin()] in few["freq"]


def test_reciprocity_says_what_the_data_allow(service: Any, beam: str, measured: str) -> None:
    alone = service.get(f"/v1/measurements/{measured}/reciprocity")
    assert alone["pairs"] == []
    assert "no pair" in alone["note"]
    rig = {"drives": ["1:+Y", "9:+Y"], "responses": ["1:+Y", "9:+Y"], "exciter": {"kind": "hammer"}}
    rig_id = service.post("/v1/rigs", rig | {"noise": {"force": 1e-3, "response": 1e-3}})["id"]
    both = service.result_of(
        "/v1/measurements", {"structure_id": beam, "rig_id": rig_id, "route": "drawn", "seed": 2}
    )
    (pair,) = service.get(f"/v1/measurements/{both}/reciprocity")["pairs"]
    assert {pair["response"], pair["force"]} == {"1:+Y", "9:+Y"}
    assert complex_of(pair["scale"]) == pytest.approx(1.0, abs=1e-3)  # noise of 1e-3
    assert not pair["differs"]


def test_two_tests_driven_at_each_others_response_have_the_same_modal_constants(
    service: Any, beam: str
) -> None:
    ids = []
    for drive in ("1:+Y", "9:+Y"):
        rig = {"drive": drive, "responses": ["1:+Y", "9:+Y"], "noise": {"force": 1e-3, "response": 1e-3}}
        body = {"structure_id": beam, "rig_id": service.post("/v1/rigs", rig)["id"], "route": "drawn"}
        measured = service.result_of("/v1/measurements", body)
        asked = {"measurement_id": measured, "bands": [[205.0, 217.0], [430.0, 450.0]]}
        ids.append(service.result_of("/v1/modal-models", asked))
    path = f"/v1/modal-models/{ids[0]}/reciprocity"
    pairs = service.get(path, params={"other": ids[1]})["pairs"]
    assert [pair["modes"] for pair in pairs] == [[1, 1], [2, 2]]
    for pair in pairs:
        # two noisy constants, each known to 1e-3, and the same bend of the neighbours in both
        assert complex_of(pair["ratio"]) == pytest.approx(1.0, abs=0.02)
    modes = [{"frequency": 20.0, "shape": [1, 1]}]
    known = service.post("/v1/modal-models/import", {"modes": modes, "dofs": ["1:+Y", "2:+Y"]})["id"]
    reply = service.request("GET", path, params={"other": known})
    assert (reply.status_code, reply.json()["code"]) == (422, "invalid_input")
    assert "no modal constants" in reply.json()["detail"]
    assert service.request("GET", path, params={"other": "none"}).status_code == 404
