"""Fits, charts and indicators: asked for by keywords, read, and drawn."""

from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest
from matplotlib import pyplot

from modallab_client import ModalLab
from modallab_client.methods.extraction import fit_of
from modallab_client.methods.measurements import measurement_of
from modallab_client.results import Measurement
from tests.client.fake import MEASUREMENT, MODE, FakeService, completed, npz

FREQ = np.linspace(90.0, 110.0, 21)
LOSS, AT = 0.04, 100.5


@pytest.fixture(autouse=True)
def _off_screen() -> Iterator[None]:
    pyplot.switch_backend("agg")
    yield
    pyplot.close("all")


def mode(freq: Any) -> Any:
    x = (2 * np.pi * freq) ** 2
    return 1 / ((2 * np.pi * AT) ** 2 * (1 + 1j * LOSS) - x)


def pairs(values: Any) -> Any:
    return np.stack([np.real(values), np.imag(values)], axis=-1).tolist()


X = (2 * np.pi * FREQ) ** 2
Z = mode(FREQ)
DETAILS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "circle_fit": (
        {
            "x": X.tolist(),
            "radius": [0.5],
            "x_above": X[11:].tolist(),
            "x_below": X[:11].tolist(),
            "damping_surface": np.full((10, 11), LOSS).tolist(),
        },
        {
            "points": pairs(Z),
            "centre": pairs(np.array([0.0 - 1e-4j])),
            "resonance": pairs(np.array([0.0 - 2e-4j])),
            "circle": pairs(1e-4 * np.exp(1j * np.linspace(0, 2 * np.pi, 50)) - 1e-4j),
        },
    ),
    "line_fit": ({"x": X.tolist()}, {"inverse": pairs(1 / Z), "line": pairs(1 / Z)}),
    "dobson": (
        {"x": X.tolist(), "x_delta": np.tile(X[1:], (3, 1)).tolist()},
        {
            "delta": pairs(np.ones((3, 20)) * 1j),
            "delta_lines": pairs(np.ones((3, 20)) * 1j),
            "slopes": pairs(X + 1j),
            "slope_line": pairs(X + 1j),
        },
    ),
    "linear_fit": ({"x": X.tolist()}, {"left": pairs(Z * X), "right": pairs(Z * X)}),
    "peak_picking": (
        {
            "x": X.tolist(),
            "magnitude": np.abs(Z).tolist(),
            "x_peak": [X[10]],
            "peak": [abs(Z[10])],
            "x_half": [X[8], X[13]],
            "half": [abs(Z[10]) / 2**0.5] * 2,
        },
        {},
    ),
}


def fit_reply(method: str, **changed: Any) -> dict[str, Any]:
    real, turning = DETAILS[method]
    reply = {
        "mode": 3,
        "response": "9:+Y",
        "method": method,
        "damping": "structural",
        "kind": "receptance",
        "freq": FREQ.tolist(),
        "used": [True] * 21,
        "measured": pairs(Z),
        "cleaned": pairs(Z),
        "curve_freq": FREQ.tolist(),
        "curve": pairs(Z),
        "frequency": AT,
        "loss_factor": LOSS,
        "modal_constant": [1.0, -0.1],
        "residual": [0.0, 0.0],
        "quality": {"radius_variation": 1.25},
        "details": real,
        "complex_details": turning,
        "new_field": 1,
    }
    return reply | changed


CHART = {
    "order": [2, 3, 3, 4],
    "frequency": [99.0, 100.4, 150.0, 100.5],
    "loss_factor": [0.05, 0.04, 0.2, 0.04],
    "stability": [0, 1, 0, 3],
    "mode": [None, 1, None, 1],
    "modes": [100.5],
    "notes": ["mode 1, 100.5 Hz: stable"],
    "indicators": {"freq": [1.0, 2.0], "inputs": ["1:+Y"], "mif": [[1.0, 0.1]], "cmif": [[1e-4, 2e-3]]},
}


def test_options_of_an_extraction_are_keywords(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/modal-models", httpx.Response(202, json={"id": "j1", "state": "queued"}))
    lab.modal_models.start("m1", method="line_fit", lines=12, leave_out=4, damping="viscous")
    assert service.body() == {
        "measurement_id": "m1",
        "method": "line_fit",
        "bands": "auto",
        "options": {"lines": 12, "leave_out": 4, "damping": "viscous"},
    }
    lab.modal_models.start("m1", method="lscf", max_order=30)
    assert service.body()["options"] == {"max_order": 30}


def test_a_modal_model_says_what_was_chosen_what_is_left_and_what_shifts(
    lab: ModalLab, service: FakeService
) -> None:
    complexity = {"mpc": 0.99, "mean_phase": 0.01, "mean_phase_deviation": 0.02}
    inconsistency = {
        "cause": "roving_mass",
        "size": 0.02,
        "size_error": 0.001,
        "unit": "kg",
        "explained": 0.97,
        "still_frequency": [23.7],
        "mode_size": [0.02],
        "mode_size_error": [0.001],
        "chi_square": [31.0],
        "degrees": [10],
    }
    about = {
        "id": "mm1",
        "modes": [{**MODE, "complexity": complexity}],
        "dofs": ["1:+Y", "3:+Y"],
        "choices": {"lines": "8: near lines see least of others"},
        "resynthesis_error": {"1:+Y": 0.01, "3:+Y": 0.02},
        "frequency_inconsistency": inconsistency,
        "notes": ["n"],
        "references": ["1:+Y"],
        "frfs": ["1:+Y", "3:+Y"],
    }
    service.on("GET /v1/modal-models/mm1", about)
    shift = np.array([[0.1, np.nan]])
    arrays = npz(
        shapes=np.ones((2, 1)),
        frequency_inconsistency_shift=shift,
        frequency_inconsistency_shift_error=np.abs(shift),
    )
    service.on("GET /v1/modal-models/mm1/arrays", arrays)
    found = lab.modal_models.get("mm1")
    assert found.choices["lines"].startswith("8: ")
    assert found.resynthesis_error == {"1:+Y": 0.01, "3:+Y": 0.02}
    assert (found.references, found.frfs) == (("1:+Y",), ("1:+Y", "3:+Y"))
    assert found.modes[0].complexity is not None
    assert found.modes[0].complexity.mpc == 0.99
    assert found.frequency_inconsistency is not None
    assert (found.frequency_inconsistency.cause, found.frequency_inconsistency.size) == ("roving_mass", 0.02)
    np.testing.assert_array_equal(found.frequency_inconsistency.shift, shift)
    assert found.notes == ("n",)


def test_a_fit_of_several_references_is_asked_for_by_both_points(lab: ModalLab, service: FakeService) -> None:
    service.on("GET /v1/modal-models/mm1/fits", fit_reply("line_fit"))
    lab.modal_models.fit("mm1", mode=3, response="9:+Y", reference="1:+Y")
    assert dict(service.requests[-1].url.params) == {"mode": "3", "response": "9:+Y", "reference": "1:+Y"}


@pytest.mark.parametrize("method", DETAILS)
def test_a_fit_is_read_and_draws_its_lines_and_what_is_its_own(
    lab: ModalLab, service: FakeService, method: str
) -> None:
    service.on("GET /v1/modal-models/mm1/fits", fit_reply(method))
    picture = lab.modal_models.fit("mm1", mode=3, response="9:+Y")
    assert dict(service.requests[-1].url.params) == {"mode": "3", "response": "9:+Y"}
    np.testing.assert_allclose(picture.cleaned, Z)
    assert picture.modal_constant == 1 - 0.1j
    size, turn, *own = picture.plot()
    assert own
    assert "radius variation 1.2 %" in size.figure._suptitle.get_text()  # type: ignore[union-attr]
    drawn = [line for line in size.lines if line.get_label() == "mode and residual"]
    np.testing.assert_allclose(np.asarray(drawn[0].get_ydata()), np.abs(Z))
    assert [line.get_label() for line in size.lines] == ["measured", "freed of others", "mode and residual"]
    assert any(len(np.asarray(line.get_xdata())) == 21 for line in turn.lines)
    assert all(axes.lines or axes.collections for axes in own)


def test_lines_that_were_left_out_are_hollow() -> None:
    used = [n not in (10, 11) for n in range(21)]
    size, turn, *_ = fit_of(fit_reply("line_fit", used=used)).plot()
    (hollow,) = (line for line in size.lines if line.get_label() == "left out")
    assert hollow.get_fillstyle() == "none"
    np.testing.assert_allclose(np.asarray(hollow.get_xdata()), FREQ[10:12])
    assert sum(line.get_fillstyle() == "none" for line in turn.lines) == 1


def test_the_carpet_is_drawn_over_frequency_whatever_the_damping() -> None:
    real, turning = DETAILS["circle_fit"]
    in_omega = {n: np.sqrt(v).tolist() if n.startswith("x") else v for n, v in real.items()}
    for damping, details in (("structural", real), ("viscous", in_omega)):
        reply = fit_reply("circle_fit", damping=damping, details=details, complex_details=turning)
        *_, carpet = fit_of(reply).plot()
        low, high = carpet.get_xlim()
        assert (low, high) == pytest.approx((89.5, 100.5), abs=0.1)  # Hz, half a line to either side
        assert np.asarray(carpet.collections[0].get_array()).shape == (10, 11)


def test_a_fit_of_few_lines_draws_without_what_is_its_own() -> None:
    picture = fit_of(fit_reply("dobson", details={}, complex_details={}))
    assert len(picture.plot()) == 2


def test_modes_are_dropped_and_merged_by_their_numbers(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/modal-models/mm1/select", {"id": "mm2"})
    service.on("GET /v1/modal-models/mm2", {"id": "mm2", "modes": [MODE], "dofs": ["1:+Y"]})
    service.on("GET /v1/modal-models/mm2/arrays", npz(shapes=np.ones((1, 1))))
    assert lab.modal_models.select("mm1", drop=[2], merge=[(3, 4)]).id == "mm2"
    assert service.body(0) == {"drop": [2], "merge": [[3, 4]]}


def test_details_are_asked_for_by_name(lab: ModalLab, service: FakeService) -> None:
    service.on("GET /v1/modal-models/mm2", {"id": "mm2", "modes": [MODE], "dofs": ["1:+Y"]})
    service.on("GET /v1/modal-models/mm2/arrays", npz(shapes=np.ones((1, 1))))
    lab.modal_models.get("mm2", details=["flags", "notes"])
    assert service.requests[0].url.query == b"details=flags&details=notes"
    lab.modal_models.get("mm2")
    assert service.requests[2].url.query == b""


def test_a_chart_draws_orders_over_frequency_by_stability(lab: ModalLab, service: FakeService) -> None:
    service.on("GET /v1/modal-models/mm1/chart", CHART)
    found = lab.modal_models.chart("mm1")
    assert found.mode == (None, 1, None, 1)
    axes = found.plot()
    by_label = {one.get_label(): np.asarray(one.get_offsets()) for one in axes.collections}
    np.testing.assert_array_equal(by_label["new"], [[99.0, 2], [150.0, 3]])
    np.testing.assert_array_equal(by_label["and in vector"], [[100.5, 4]])
    np.testing.assert_array_equal(by_label["speaks for a mode"], [[100.4, 3], [100.5, 4]])
    (behind,) = (one for one in axes.figure.axes if one is not axes)
    np.testing.assert_array_equal(np.asarray(behind.lines[0].get_ydata()), [1e-4, 2e-3])


def test_a_chart_marks_doubtful_poles_by_their_reason(lab: ModalLab, service: FakeService) -> None:
    doubtful = [
        {"frequency": 99.0, "loss_factor": 0.05, "reason": "stable at only 2 of 9 orders"},
        {"frequency": 150.0, "loss_factor": None, "reason": "negative damping"},
        {"frequency": 151.0, "loss_factor": 0.2, "reason": "stable at only 3 of 9 orders"},
    ]
    service.on("GET /v1/modal-models/mm1/chart", {**CHART, "doubtful": doubtful})
    axes = lab.modal_models.chart("mm1").plot()
    marks = {str(line.get_label()): line for line in axes.lines if "doubtful" in str(line.get_label())}
    assert [list(np.asarray(line.get_xdata())) for line in marks.values()] == [[99.0, 151.0], [150.0]]
    assert [" ".join(label.split()) for label in marks] == [
        "doubtful: stable at only … of … orders",
        "doubtful: negative damping",
    ]


def test_indicators_draw_cmif_over_mif(lab: ModalLab, service: FakeService) -> None:
    service.on("GET /v1/measurements/m1/indicators", CHART["indicators"])  # type: ignore[arg-type]
    upper, lower = lab.measurements.indicators("m1", points=100).plot()
    assert service.requests[-1].url.params["points"] == "100"
    np.testing.assert_array_equal(np.asarray(upper.lines[0].get_ydata()), [1e-4, 2e-3])
    np.testing.assert_array_equal(np.asarray(lower.lines[0].get_ydata()), [1.0, 0.1])


def test_reciprocity_tabulates_its_pairs(lab: ModalLab, service: FakeService) -> None:
    pair = {"response": "1:+Y", "force": "9:+Y", "scale": [-1.0, 0.0], "difference": 2.0}
    reply = {"pairs": [pair | {"misfit": None, "differs": True}], "note": "2 points"}
    service.on("GET /v1/measurements/m1/reciprocity", reply)
    found = lab.measurements.reciprocity("m1")
    assert found.pairs[0].scale == -1
    assert found.pairs[0].misfit is None
    assert "-1.000" in found.table()
    assert "2 points" in found._repr_html_()


def test_modal_constants_of_two_tests_are_compared(lab: ModalLab, service: FakeService) -> None:
    pair = {"modes": [1, 2], "ratio": [1.0, 0.01], "ratio_error": 0.02, "differs": False}
    service.on("GET /v1/modal-models/a/reciprocity", {"pairs": [pair]})
    (found,) = lab.modal_models.reciprocity("a", "b")
    assert service.requests[-1].url.params["other"] == "b"
    assert (found.modes, found.ratio, found.differs) == ((1, 2), 1 + 0.01j, False)


def measured() -> Measurement:
    return measurement_of(
        completed(Measurement, {"id": "m1"}), {name: np.asarray(value) for name, value in MEASUREMENT.items()}
    )


def test_made_frfs_are_drawn_before_the_measured_ones(lab: ModalLab, service: FakeService) -> None:
    names = ("freq", "values", "outputs", "inputs", "kind")
    service.on("GET /v1/modal-models/mm1/frf", npz(**{name: MEASUREMENT[name] for name in names}))
    made = lab.modal_models.frf("mm1", kind="inertance")
    assert service.requests[-1].url.params["kind"] == "inertance"
    upper, lower = made.plot(measured(), output="3:+Y")
    assert [line.get_label() for line in upper.lines] == ["measured", "3:+Y / 1:+Y"]
    np.testing.assert_allclose(np.asarray(lower.lines[1].get_ydata()), 45.0)  # of 1 + i
    upper, _ = made.plot()
    assert [line.get_label() for line in upper.lines] == ["1:+Y / 1:+Y", "3:+Y / 1:+Y"]
    with pytest.raises(ValueError, match="ask for one kind"):
        lab.modal_models.frf("mm1").plot(_of_kind("mobility"))


def _of_kind(kind: str) -> Measurement:
    arrays = {name: np.asarray(value) for name, value in MEASUREMENT.items()}
    return measurement_of(completed(Measurement, {"id": "m1"}), arrays | {"kind": np.array(kind)})
