"""A roving hammer over HTTP, from the declared rig to modes without the window's damping."""

import io
from typing import Any

import numpy as np
import pytest

POINTS = ["1:+Y", "5:+Y", "11:+Y", "16:+Y"]
ANALYSER = {"frequency_max": 400.0, "n_lines": 401, "averages": 5}


def arrays(service: Any, id: str) -> Any:
    return np.load(io.BytesIO(service.request("GET", f"/v1/measurements/{id}/arrays").content))


def measured(service: Any, structure: str, rig: dict[str, Any], route: str = "sampled") -> str:
    rig_id = service.post("/v1/rigs", rig)["id"]
    body = {"structure_id": structure, "rig_id": rig_id, "route": route, "seed": 3}
    return str(service.result_of("/v1/measurements", body))


def hammer(**excitation: Any) -> dict[str, Any]:
    rig: dict[str, Any] = {"exciter": {"kind": "hammer"}, "analyser": dict(ANALYSER)}
    if excitation:
        rig["analyser"]["excitation"] = excitation
    return rig


def test_a_hammer_strikes_unless_told_otherwise(service: Any) -> None:
    rig = service.post("/v1/rigs", hammer() | {"drive": "1:+Y", "responses": POINTS})
    assert rig["analyser"]["excitation"]["kind"] == "impact"
    harder = service.post("/v1/rigs", hammer(tip_stiffness=1e8) | {"drive": "1:+Y", "responses": POINTS})
    assert harder["analyser"]["excitation"]["kind"] == "impact"
    assert harder["analyser"]["excitation"]["tip_stiffness"] == 1e8
    shaker = service.post("/v1/rigs", {"drive": "1:+Y", "responses": POINTS})
    assert shaker["analyser"]["excitation"]["kind"] == "periodic_random"


@pytest.mark.parametrize(
    ("stated", "shape"),
    [
        ({"kind": "impact"}, "unknown"),
        ({"level_scatter": 0.2}, "unknown"),
        ({"kind": "impact", "tip_stiffness": 1e7}, "flat"),
        ({"kind": "impact", "level": 1.0}, "flat"),
        ({"kind": "periodic_random"}, "flat"),
    ],
)
def test_pulse_of_which_nothing_is_stated_is_unknown(
    service: Any, stated: dict[str, Any], shape: str
) -> None:
    rig = service.post("/v1/rigs", hammer(**stated) | {"drive": "1:+Y", "responses": POINTS})
    assert rig["analyser"]["excitation"]["shape"] == shape


@pytest.mark.parametrize("route", ["expected", "drawn", "sampled"])
def test_a_roving_hammer_measures_what_a_roving_accelerometer_does(
    service: Any, beam: str, route: str
) -> None:
    hit = arrays(
        service, measured(service, beam, hammer() | {"drives": POINTS, "responses": ["5:+Y"]}, route)
    )
    heard = arrays(service, measured(service, beam, hammer() | {"drive": "5:+Y", "responses": POINTS}, route))
    assert hit["values"].shape == hit["coherence"].shape == (401, 1, 4)
    assert heard["values"].shape == (401, 4, 1)
    assert heard["coherence"].shape == (401, 4)
    # reciprocity, H_jk = H_kj; without noise up to the rounding of two solutions
    scale = np.abs(heard["values"]).max()
    np.testing.assert_allclose(hit["values"][:, 0, :], heard["values"][:, :, 0], atol=1e-7 * scale)


def test_every_pair_of_a_roving_hammer_and_fixed_accelerometers_is_reciprocal(
    service: Any, beam: str
) -> None:
    rig = hammer(level_scatter=0.2) | {"drives": POINTS, "responses": POINTS}
    found = arrays(service, measured(service, beam, rig | {"noise": {"force": 1e-4, "response": 1e-4}}))
    h, g2 = found["values"], found["coherence"]
    assert h.shape == g2.shape == (401, 4, 4)
    assert found["force_spectrum"].shape == (401, 4, 4)
    error = np.sqrt((1 - g2) / (2 * 5 * np.maximum(g2, 1e-9)))
    apart = np.abs(h - h.swapaxes(1, 2)) / np.abs(h)
    within = apart < 4 * np.sqrt(2) * np.maximum(error + error.swapaxes(1, 2), 1e-9)
    # five averages: the error from a coherence of five is itself uncertain
    assert within[1:].mean() > 0.95
    assert (found["inputs"] == found["outputs"]).all()


def test_the_damping_of_an_exponential_window_is_told_and_taken_out_on_request(
    service: Any, beam: str
) -> None:
    rig = hammer() | {"drive": "1:+Y", "responses": POINTS}
    rig["analyser"] |= {"window": "force_exponential", "window_end": 1e-3}
    id = measured(service, beam, rig)
    (note,) = service.get(f"/v1/measurements/{id}")["notes"]
    assert "sigma = 6.908 1/s" in note  # ln(1000) over a record of 1 s
    found = []
    for correct in (False, True):
        body = {"measurement_id": id, "n_modes": 4, "correct_window_damping": correct}
        found.append(service.get(f"/v1/modal-models/{service.result_of('/v1/modal-models', body)}"))
    truth = service.get(f"/v1/structures/{beam}/modes", params={"count": 6})
    raw, corrected = ([mode["loss_factor"] for mode in model["modes"]] for model in found)
    frequency = np.array([mode["frequency"] for mode in found[0]["modes"]])
    same = np.abs(np.subtract.outer(frequency, truth["frequencies"])).argmin(axis=1)
    wanted = np.array(truth["loss_factors"])[same]
    np.testing.assert_allclose(np.subtract(raw, corrected), 6.908 / np.pi / frequency, rtol=1e-3)
    # a hysteretic pole moves as a viscous one to first order in its loss factor, 3 % at most
    np.testing.assert_allclose(corrected, wanted, rtol=0.01)
    assert (np.array(raw) > 2 * wanted).all()
    assert "exponential window" in " ".join(found[1]["notes"])


def test_the_catalogue_says_what_an_excitation_asks_for(service: Any) -> None:
    kinds = {entry["kind"]: entry for entry in service.get("/v1/catalog/excitations")}
    assert set(kinds) >= {
        "random",
        "pseudo_random",
        "periodic_random",
        "burst_random",
        "chirp",
        "stepped_sine",
        "impact",
    }
    assert kinds["burst_random"]["parameters"]["burst"]["unit"] == "1"
    assert kinds["impact"]["parameters"]["tip_stiffness"]["unit"] == "N/m"
    windows = {entry["kind"] for entry in service.get("/v1/catalog/windows")}
    assert windows >= {"rectangular", "hann", "flat_top", "force", "exponential", "force_exponential"}
