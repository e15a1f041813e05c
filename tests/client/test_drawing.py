"""Results in a notebook: drawn and tabulated."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.patches import Rectangle

from modallab_client import _wire, _wire_findings
from modallab_client.models import Measurement
from tests.client.fake import DIAGNOSIS, MEASUREMENT, MODE, UPDATE

MODEL = {"id": "mm1", "modes": [MODE], "method": "dobson", "dofs": ["1:+Y", "3:+Y"]}
SHAPES = {"shapes": np.ones((2, 1))}


@pytest.fixture(autouse=True)
def _off_screen() -> Iterator[None]:
    pyplot.switch_backend("agg")
    yield
    pyplot.close("all")


def measurement() -> Measurement:
    return _wire.measurement({"id": "m<1>"}, {name: np.asarray(value) for name, value in MEASUREMENT.items()})


def test_a_measurement_shows_magnitude_over_coherence() -> None:
    test = measurement()
    upper, lower = test.plot()
    assert [line.get_label() for line in upper.lines] == ["1:+Y / 1:+Y", "3:+Y / 1:+Y"]
    np.testing.assert_array_equal(upper.lines[1].get_ydata(), np.abs(test.values[1:, 1, 0]))
    assert upper.get_ylabel() == "|inertance|, m/(s² N)"
    assert len(lower.lines) == 2
    np.testing.assert_array_equal(lower.lines[0].get_xdata(), [2.0, 4.0], "nothing moves at 0 Hz")


def test_the_gap_is_drawn_by_step() -> None:
    axes = _wire_findings.diagnosis(DIAGNOSIS).plot()
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), [812.0, 1.04])
    np.testing.assert_array_equal(axes.lines[1].get_ydata(), [790.0, 1.06])
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["as given", "+ extra_mass"]


def test_a_diagnosis_without_steps_draws_its_one_gap() -> None:
    nothing: dict[str, Any] = {**DIAGNOSIS, "steps": [], "verdict": "nothing_missing", "next_test": None}
    axes = _wire_findings.diagnosis(nothing).plot()
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), [1.06])


def test_modes_coefficients_and_mac_draw_themselves() -> None:
    modes = _wire.modal_model(MODEL, SHAPES).plot()
    np.testing.assert_array_equal(modes.lines[0].get_xydata(), [[23.61, 0.0051]])
    bars = _wire_findings.update(UPDATE).plot()
    ends = [bar.get_y() + bar.get_height() for bar in bars.patches if isinstance(bar, Rectangle)]
    np.testing.assert_allclose(ends, [2.0, 2.0, 1.99])  # 1 + (x - 1) rounds in the last digit
    reply = {"mac": [[1.0, 0.1]], "pairs": [[1, 1]], "frequency_differences": [0.0], "comac": [1.0]}
    np.testing.assert_array_equal(
        _wire_findings.correlation(reply).plot().images[0].get_array(), [[1.0, 0.1]]
    )


def test_the_curves_of_a_diagnosis_are_measured_before_and_after() -> None:
    frf = np.ones((3, 2, 1)) + 0j
    arrays = {
        "freq": np.arange(3.0),
        "measured": frf,
        "before": 2 * frf,
        "after": frf,
        "random_error": frf.real,
        "held_out": np.array([False, True]),
        "outputs": np.array(["1:+Y", "3:+Y"]),
        "inputs": np.array(["1:+Y"]),
    }
    axes = _wire_findings.diagnosis_curves(arrays).plot("3:+Y")
    assert [line.get_label() for line in axes.lines] == ["measured", "before", "after"]
    np.testing.assert_array_equal(axes.lines[1].get_ydata(), 2.0)


def test_tables_are_escaped_for_the_notebook() -> None:
    assert "Measurement m&lt;1&gt;" in measurement()._repr_html_()
    assert "<td>extra_mass at 7:+Y: mass 0.05 kg</td>" in _wire_findings.diagnosis(DIAGNOSIS)._repr_html_()
    assert "<th>coefficient</th>" in _wire_findings.update(UPDATE)._repr_html_()
    assert "dobson" in _wire.modal_model(MODEL, SHAPES)._repr_html_()
    modes = _wire.structure_modes({"frequencies": [1.0], "loss_factors": [0.1], "n_rigid_body": 2})
    assert "2 rigid-body modes" in modes._repr_html_()
    assert (
        repr(measurement()) == "Measurement('m<1>', inertance, 2 outputs x 1 inputs, 3 lines from 0 to 4 Hz)"
    )
