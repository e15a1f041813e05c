"""What a modal model shows of how it was found: choices, what is left, complexity, frequencies."""

import io
from typing import Any

import numpy as np
import pytest

RESPONSES = [f"{n}:+Y" for n in range(1, 22, 4)]


@pytest.fixture(scope="module")
def measured(service: Any, beam: str, rig: str) -> str:
    """A test with 0.1 % noise."""
    return str(service.result_of("/v1/measurements", {"structure_id": beam, "rig_id": rig, "route": "drawn"}))


def arrays(service: Any, id: str) -> Any:
    return np.load(io.BytesIO(service.request("GET", f"/v1/modal-models/{id}/arrays").content))


def extracted(service: Any, measured: str, **asked: Any) -> Any:
    id = service.result_of("/v1/modal-models", {"measurement_id": measured, "n_modes": 8} | asked)
    return service.get(f"/v1/modal-models/{id}")


def test_what_was_chosen_is_told_with_the_reason(service: Any, measured: str) -> None:
    choices = extracted(service, measured)["choices"]
    assert choices["lines"].startswith("8: ")
    assert "no leakage" in choices["lines"]
    assert choices["damping"].startswith("structural: determined from the lines")


def test_what_was_asked_for_is_done(service: Any, measured: str) -> None:
    options = {"lines": 14, "leave_out": 2, "damping": "viscous"}
    found = extracted(service, measured, method="linear_fit", options=options)
    assert found["choices"]["lines"] == "14: as requested"
    assert found["choices"]["leave_out"] == "2: as requested"
    assert found["choices"]["damping"] == "viscous: as requested"
    ends = arrays(service, found["id"])["fitted_lines"]
    assert (np.diff(ends, axis=2) + 1 == 14).all()


def test_modes_and_residuals_leave_little_of_each_frf(service: Any, measured: str) -> None:
    left = extracted(service, measured)["resynthesis_error"]
    assert list(left) == RESPONSES
    # the random error of the lines is 1e-4; windows of eight lines see the others' bend as 1 %
    assert max(left.values()) < 0.02


def test_shapes_of_proportional_damping_are_in_step(service: Any, measured: str) -> None:
    for mode in extracted(service, measured)["modes"]:
        said = mode["complexity"]
        assert said["mpc"] > 0.999  # noise of 1e-3 over 100 averages turns a component by 1e-3 rad
        assert abs(said["mean_phase"]) < 0.02  # rad: scaled by the drive point, which is real
        assert 0 <= said["mean_phase_deviation"] < 0.02


def test_a_wave_that_travels_is_seen_in_imported_shapes(service: Any) -> None:
    modes = [{"frequency": 20.0, "shape": [[1, 0], [0, 1]]}, {"frequency": 30.0, "shape": [1, -1]}]
    stored = service.post("/v1/modal-models/import", {"modes": modes, "dofs": ["1:+Y", "2:+Y"]})
    travelling, standing = (mode["complexity"] for mode in stored["modes"])
    assert travelling["mpc"] == pytest.approx(0.0, abs=1e-12)  # rounding
    assert standing == {"mpc": pytest.approx(1.0), "mean_phase": 0.0, "mean_phase_deviation": 0.0}
    assert stored["resynthesis_error"] is None
    assert stored["frequency_inconsistency"] is None
    assert stored["choices"] == {}


def test_frequencies_of_one_structure_do_not_wander(service: Any, measured: str) -> None:
    assert extracted(service, measured)["frequency_inconsistency"] is None


@pytest.mark.parametrize("method", ["circle_fit", "dobson", "line_fit", "linear_fit", "peak_picking"])
def test_every_single_mode_method_runs_over_http(service: Any, measured: str, beam: str, method: str) -> None:
    found = [mode["frequency"] for mode in extracted(service, measured, method=method)["modes"]]
    exact = service.get(f"/v1/structures/{beam}/modes", params={"count": 8})["frequencies"]
    # a peak is known to half a line of 2 Hz; fits to the random error and the bend of others
    atol = 1.0 if method == "peak_picking" else 0.05
    np.testing.assert_allclose(found, exact, atol=atol)


@pytest.mark.parametrize("name", ["bands", "exclude"])
def test_bands_beyond_the_test_are_refused_before_the_job(service: Any, measured: str, name: str) -> None:
    body = {"measurement_id": measured, name: [[20.0, 30.0], [900.0, 950.0]]}
    refused = service.post("/v1/modal-models", body, status=422)
    assert refused["context"]["field"] == name
    assert refused["context"]["value"] == [900.0, 950.0]
    assert "0 to 800 Hz" in refused["detail"]
