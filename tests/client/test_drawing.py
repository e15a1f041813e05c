"""Results in a notebook: drawn and tabulated."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.patches import Rectangle

from modallab_client._read import read_as
from modallab_client.methods.measurements import measurement_of
from modallab_client.methods.modal_models import modal_model_of
from modallab_client.methods.updates import update_of
from modallab_client.models import ComplexArray
from modallab_client.results import (
    Correlation,
    Diagnosis,
    DiagnosisCurves,
    FittedParameter,
    Measurement,
    ModalModel,
    StructureModes,
)
from tests.client.fake import DIAGNOSIS, MEASUREMENT, MODE, UPDATE, completed

MODEL = completed(ModalModel, {"id": "mm1", "modes": [MODE], "method": "dobson", "dofs": ["1:+Y", "3:+Y"]})
SHAPES = {"shapes": np.ones((2, 1))}


@pytest.fixture(autouse=True)
def _off_screen() -> Iterator[None]:
    pyplot.switch_backend("agg")
    yield
    pyplot.close("all")


def measurement() -> Measurement:
    return measurement_of(
        completed(Measurement, {"id": "m<1>"}),
        {name: np.asarray(value) for name, value in MEASUREMENT.items()},
    )


def test_a_measurement_shows_magnitude_over_coherence() -> None:
    test = measurement()
    upper, lower = test.plot()
    assert [line.get_label() for line in upper.lines] == ["1:+Y / 1:+Y", "3:+Y / 1:+Y"]
    np.testing.assert_array_equal(upper.lines[1].get_ydata(), np.abs(test.values[1:, 1, 0]))
    assert upper.get_ylabel() == "|inertance|, m/(s² N)"
    assert len(lower.lines) == 2
    np.testing.assert_array_equal(lower.lines[0].get_xdata(), [2.0, 4.0], "nothing moves at 0 Hz")


def test_frfs_to_several_inputs_are_drawn_each_over_their_coherence() -> None:
    single = measurement()
    assert single.coherence is not None
    values = np.concatenate([single.values, 2 * single.values], axis=2)
    inputs = (*single.inputs, "3:+Y")
    of_shakers = replace(single, values=values, inputs=inputs)  # their coherence is the multiple one
    roved = replace(of_shakers, coherence=np.repeat(single.coherence[:, :, None], 2, axis=2))
    for test, n_coherences in ((of_shakers, 2), (roved, 4)):
        upper, lower = test.plot()
        labels = [line.get_label() for line in upper.lines]
        assert labels == ["1:+Y / 1:+Y", "1:+Y / 3:+Y", "3:+Y / 1:+Y", "3:+Y / 3:+Y"]
        np.testing.assert_array_equal(upper.lines[3].get_ydata(), np.abs(values[1:, 1, 1]))
        assert len(lower.lines) == n_coherences


def test_loss_factors_are_drawn_from_no_change_as_coefficients_are() -> None:
    found = {**UPDATE, "coefficients": {"stiffness": {"11": 2.0}, "damping": {"11": 0.05}}}
    axes = update_of(found).plot()
    bars = [bar for bar in axes.patches if isinstance(bar, Rectangle)]
    np.testing.assert_allclose([bar.get_y() + bar.get_height() for bar in bars], [2.0, 1.05])
    _, labels = axes.get_legend_handles_labels()
    assert labels == ["stiffness", "damping: 1 + loss factor"]


def lengths(axes: Any) -> list[float]:
    """Return where the bars of a drawing end."""
    return [bar.get_x() + bar.get_width() for bar in axes.patches if isinstance(bar, Rectangle)]


def test_the_gap_is_drawn_by_step_over_fitted_and_held_out_frfs() -> None:
    (axes,) = read_as(Diagnosis, DIAGNOSIS).plot()
    np.testing.assert_allclose(lengths(axes), [812.0, 1.04, 790.0, 1.06])
    assert [tick.get_text() for tick in axes.get_yticklabels()] == ["as given", "+ extra mass\nat 7:+Y"]
    assert "mass 0.05000 ± 0.00040 kg" in axes.get_title()


def test_a_diagnosis_without_steps_draws_its_one_gap() -> None:
    nothing: dict[str, Any] = {**DIAGNOSIS, "steps": [], "verdict": "nothing_missing", "next_test": None}
    (axes,) = read_as(Diagnosis, nothing).plot()
    np.testing.assert_allclose(lengths(axes), [1.06])
    assert axes.get_title() == "nothing missing"


def test_with_curves_a_diagnosis_draws_where_it_parts_and_the_clearest_difference() -> None:
    found = replace(read_as(Diagnosis, DIAGNOSIS), curves=resonances())
    gap, where, size, turn = found.plot()
    assert len(lengths(gap)) == 4
    # 40 lines of two responses, one of them held out
    assert np.asarray(where.collections[0].get_array()).shape == (2, 40)
    assert [tick.get_text() for tick in where.get_yticklabels()] == ["1:+Y", "3:+Y *"]
    before, after, measured = (np.asarray(line.get_xydata()) for line in size.lines[:3])
    assert size.get_title() == "response 3:+Y / 1:+Y, held out of every fit"
    # enlarged: the resonance at 120 Hz, and not all 40 lines
    assert before[0, 0] < 120 < before[-1, 0]
    assert len(before) < 30
    np.testing.assert_array_equal(after[:, 1], measured[:, 1])
    assert (np.abs(before[:, 1] / measured[:, 1] - 1) > 0.1).any()
    assert turn.get_ylabel() == "phase, degrees"


def test_curves_that_agree_are_drawn_over_all_lines() -> None:
    agreeing = replace(resonances(), before=resonances().after)
    nothing: dict[str, Any] = {**DIAGNOSIS, "steps": [], "verdict": "nothing_missing", "next_test": None}
    _, _, size, _ = replace(read_as(Diagnosis, nothing), curves=agreeing).plot()
    assert len(np.asarray(size.lines[0].get_xdata())) == 39  # nothing moves at 0 Hz


def test_a_difference_that_curves_do_not_show_is_drawn_as_a_ratio() -> None:
    curves = resonances()
    high = replace(curves, before=curves.after / 1.05, random_error=np.full((40, 2, 1), 0.002))
    *_, size, turn = replace(read_as(Diagnosis, DIAGNOSIS), curves=high).plot()
    assert size.get_ylabel() == "magnitude against the prediction, %"
    np.testing.assert_allclose(np.asarray(size.lines[0].get_ydata()), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.asarray(size.lines[1].get_ydata()), 5.0, rtol=1e-9)
    np.testing.assert_allclose(np.asarray(turn.lines[1].get_ydata()), 0.0, atol=1e-9)


def test_what_is_left_open_stands_under_the_table() -> None:
    words = read_as(Diagnosis, DIAGNOSIS)._repr_html_()
    assert "This test cannot tell extra mass at 7:+Y from force transducer mass." in words
    assert "Next test: level factor 3.0; w." in words


@pytest.mark.parametrize(
    ("value", "error", "unit", "words"),
    [
        (0.05, 4e-4, "kg", "0.05000 ± 0.00040 kg"),
        (1.2, 3e-5, "1", "1.200000 ± 0.000030"),
        (2.0e6, 3.1e4, "N/m", "(2.000 ± 0.031)e6 N/m"),
        (2.0e-5, 1e-7, "s", "(2.000 ± 0.010)e-5 s"),
        (5e4, 700.0, "N/m", "50000 ± 700 N/m"),
        (0.05, None, "kg", "0.05 kg"),
        (0.0, 0.002, "", "0.0000 ± 0.0020"),
    ],
)
def test_a_number_has_two_digits_of_its_error(
    value: float, error: float | None, unit: str, words: str
) -> None:
    assert str(FittedParameter(value=value, standard_error=error, unit=unit)) == words


def test_modes_coefficients_and_mac_draw_themselves() -> None:
    modes = modal_model_of(MODEL, SHAPES).plot()
    np.testing.assert_array_equal(modes.lines[0].get_xydata(), [[23.61, 0.0051]])
    bars = update_of(UPDATE).plot()
    ends = [bar.get_y() + bar.get_height() for bar in bars.patches if isinstance(bar, Rectangle)]
    np.testing.assert_allclose(ends, [2.0, 2.0, 1.99])  # 1 + (x - 1) rounds in the last digit
    reply = {"mac": [[1.0, 0.1]], "pairs": [[1, 1]], "frequency_differences": [0.0], "comac": [1.0]}
    np.testing.assert_array_equal(
        read_as(Correlation, completed(Correlation, reply)).plot().images[0].get_array(), [[1.0, 0.1]]
    )


def resonances() -> DiagnosisCurves:
    """Return a resonance at 120 Hz that was predicted 5 % too high, and after an addition as it is."""
    freq = np.linspace(0.0, 390.0, 40)

    def frf(resonance: float) -> ComplexArray:
        one = -(freq**2) / (resonance**2 * (1 + 0.05j) - freq**2)
        return np.asarray(one[:, None, None] * np.array([1.0, 2.0])[:, None], complex)

    return DiagnosisCurves(
        freq=freq,
        measured=frf(120.0),
        before=frf(126.0),
        after=frf(120.0),
        random_error=np.full((40, 2, 1), 0.01),
        held_out=np.array([False, True]),
        outputs=("1:+Y", "3:+Y"),
        inputs=("1:+Y",),
    )


def test_the_curves_of_a_diagnosis_are_measured_before_and_after() -> None:
    curves = resonances()
    axes = curves.plot("3:+Y")
    assert [line.get_label() for line in axes.lines] == ["measured", "before", "after"]
    np.testing.assert_array_equal(axes.lines[1].get_ydata(), np.abs(curves.before[1:, 1, 0]))
    assert axes.get_title() == "response 3:+Y / 1:+Y, held out of every fit"


def test_tables_are_escaped_for_the_notebook() -> None:
    diagnosed = read_as(Diagnosis, DIAGNOSIS)._repr_html_()
    assert "Measurement m&lt;1&gt;" in measurement()._repr_html_()
    assert "<td>extra mass at 7:+Y: mass 0.05000 ± 0.00040 kg</td>" in diagnosed
    assert "<th>coefficient</th>" in update_of(UPDATE)._repr_html_()
    assert "dobson" in modal_model_of(MODEL, SHAPES)._repr_html_()
    given = {"id": "s1", "frequencies": [1.0], "loss_factors": [0.1], "n_rigid_body": 2}
    modes = read_as(StructureModes, completed(StructureModes, given))
    assert "2 rigid-body modes" in modes._repr_html_()
    assert (
        repr(measurement()) == "Measurement('m<1>', inertance, 2 outputs x 1 inputs, 3 lines from 0 to 4 Hz)"
    )


def flagged() -> ModalModel:
    mode = {
        **MODE,
        "flags": ["node: 3 FRFs, such as 5:+Y", "pair: <a>"],
        "flag_counts": {"pair": 1, "node": 3},
    }
    doubtful = [{"frequency": 799.9, "loss_factor": None, "reason": "at an edge <of the range>"}]
    more = {"modes": [mode], "doubtful": doubtful, "main_flags": ["mode 1: pair: <a>"]}
    return modal_model_of({**MODEL, **more}, SHAPES)


def test_a_table_of_modes_has_standard_errors_flags_and_doubtful_poles_below() -> None:
    lines = flagged().table().splitlines()
    assert lines[0].split() == [
        *("mode", "quantity", "value", "std", "error", "min", "max", "mean", "sd", "flags")
    ]
    assert lines[1].split() == [
        "1",
        "frequency",
        "Hz",
        "23.610",
        "0.015",
        "23.5",
        "23.7",
        "23.61",
        "0.05",
        "pair,",
        "node",
        "(3)",
    ]
    assert "mode 1: pair: <a>" in lines
    assert lines[-1].split(maxsplit=1) == ["799.9", "at an edge <of the range>"]


def test_a_notebook_shows_the_same_with_every_word_escaped() -> None:
    shown = flagged()._repr_html_()
    assert "<th>std error</th>" in shown
    assert "pair, node (3)" in shown
    assert "<p>mode 1: pair: &lt;a&gt;</p>" in shown
    assert "at an edge &lt;of the range&gt;" in shown
    assert "Doubtful poles" not in modal_model_of(MODEL, SHAPES)._repr_html_()


def test_modes_without_scatter_have_no_columns_of_it() -> None:
    alone = {**MODE, "frequency_spread": None, "loss_factor_spread": None}
    head, *_ = modal_model_of({**MODEL, "modes": [alone]}, SHAPES).table().splitlines()
    assert head.split() == ["mode", "quantity", "value", "std", "error", "flags"]
