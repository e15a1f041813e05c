"""Tests of the second simulator: nothing shared with the package, and both agree where a model is exact."""

import ast
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

import benchmarks.laboratory
from benchmarks.laboratory.draws import BASES, SINGLES, UNKNOWN, bars_of, drawn
from benchmarks.laboratory.effects import Delay, Misplaced, Swapped
from benchmarks.laboratory.hiding import hide
from benchmarks.laboratory.plan import WINDOW_END
from benchmarks.laboratory.simulation import measure
from benchmarks.laboratory_trial import measurement_of, score, structure_of
from modallab.core.dof import Dof
from modallab.diagnosis.diagnose import diagnose_with_options
from modallab.diagnosis.optimisation.tolerances import TolerancePreset
from modallab.diagnosis.options import DiagnosisOptions
from modallab.diagnosis.result import Diagnosis, Verdict
from modallab.effects.joint_flexibility import JointFlexibility
from modallab.fe.assembly import assemble

HAMMER, HANN, PERIODIC = 8, 5, 1  # numbers of such tests of seed 1
EXACT = DiagnosisOptions(tolerances=TolerancePreset.NONE)


def test_laboratory_imports_nothing_of_the_package() -> None:
    for path in Path(benchmarks.laboratory.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [name for name in names if name.split(".")[0].startswith("modallab")], path.name


@pytest.mark.parametrize("base", BASES)
def test_modes_are_those_of_the_package(base: str) -> None:
    bars = bars_of(base)
    squares = bars.modes[0]
    ours = assemble(structure_of(bars)).base_modes(1e9).eigenvalues.real[:12]
    rigid = int((squares < 1e-6 * squares[11]).sum())
    # Two eigensolvers and two orders of summation.
    np.testing.assert_allclose(np.sort(ours)[rigid:], squares[rigid:12], rtol=1e-6)


@pytest.mark.parametrize("number", [HAMMER, HANN, PERIODIC])
def test_exact_model_misses_nothing(number: int) -> None:
    test = drawn(number, 1)
    measured = measure(test.model, test.plan, (), np.random.default_rng(1))
    found = diagnose_with_options(structure_of(test.model), measurement_of(test.plan, measured), EXACT)
    assert found.verdict is Verdict.NOTHING_MISSING
    assert found.remaining_gap == pytest.approx(1.0, abs=0.3)  # its scatter, and the shape of a pulse


def test_a_late_channel_of_a_hammer_test_is_only_late() -> None:
    test = drawn(HAMMER, 1)
    plan, late = replace(test.plan, noise=1e-12), 1e-6
    without, with_delay = (
        measure(test.model, plan, effects, np.random.default_rng(0)).inertance
        for effects in ((), (Delay(late),))
    )
    damping = -np.log(WINDOW_END) * plan.spacing
    expected = without * np.exp(-(damping + 2j * np.pi * plan.freq) * late)[:, None, None]
    # A late response is cut off a little earlier, where a thousandth of its weight is left.
    assert np.abs(with_delay - expected).max() < 1e-5 * np.abs(without).max()


@pytest.mark.parametrize("name", [*SINGLES, *UNKNOWN])
def test_every_effect_changes_what_is_measured(name: str) -> None:
    test = drawn(PERIODIC, 1)
    effect = hide(name, test.plan, test.model, np.random.default_rng(3))
    plan = replace(test.plan, n_lines=101)
    without, with_effect = (
        measure(test.model, plan, effects, np.random.default_rng(0)) for effects in ((), (effect,))
    )
    changed = [
        np.abs(np.log(getattr(with_effect, part) / getattr(without, part))).max()
        for part in ("inertance", "force", "response")
    ]
    assert max(changed) > 0.01  # without an effect the same random numbers give the same values


@pytest.mark.parametrize("base", ["beam", "frame"])
def test_a_joint_is_that_of_the_package(base: str) -> None:
    bars = replace(bars_of(base), joints={3: 1e-3})
    squares = bars.modes[0]
    jointed = JointFlexibility(Dof(4, "RZ"), 1e-3).added_to(structure_of(bars))
    ours = np.sort(assemble(jointed).modes(np.sqrt(squares[12]) / (2 * np.pi)).eigenvalues.real)[:12]
    rigid = int((squares < 1e-6 * squares[11]).sum())
    # Two eigensolvers and two orders of summation.
    np.testing.assert_allclose(ours[rigid:], squares[rigid:12], rtol=1e-6)


def test_an_accelerometer_that_sits_elsewhere_can_be_exchanged_too() -> None:
    plan = drawn(PERIODIC, 1).plan
    runs = Misplaced(0.0, at=0, other=17).true_runs(plan.runs)
    exchanged = Swapped(0.0, at=0, other=1).true_runs(runs)
    assert [run.true[0] for run in exchanged[:2]] == [plan.listening[1], 17]


def test_what_is_named_is_judged_by_kind_and_place() -> None:
    test = drawn(PERIODIC, 1)  # a wrong member
    measured = measure(test.model, test.plan, test.hidden, np.random.default_rng(1))
    options = DiagnosisOptions(tolerances=TolerancePreset.NONE, suspects=("stiffness_error",))
    found = diagnose_with_options(structure_of(test.model), measurement_of(test.plan, measured), options)
    line = score(test, found)
    assert line["right"]
    assert line["steps"][0]["true"]
    elsewhere = replace(test, hidden=(replace(test.hidden[0], at=(test.hidden[0].at + 5) % 20),))
    assert not score(elsewhere, found)["right"]


def test_a_test_is_the_same_whatever_is_drawn_before() -> None:
    assert drawn(3, 1).hidden == drawn(3, 1).hidden


@pytest.mark.parametrize("spectra", [True, False])
def test_a_stinger_counts_where_the_force_is_handed_over(spectra: bool) -> None:
    test = drawn(32, 7)
    assert test.hidden[0].kind == "stinger_axial"
    test = replace(test, plan=replace(test.plan, spectra=spectra))
    nothing = Mock(
        spec=Diagnosis, steps=(), detection_limits=(), verdict=Verdict.NOTHING_MISSING, remaining_gap=1.0
    )
    assert score(test, nothing)["visible"] is spectra
