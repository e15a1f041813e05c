"""Modal models after modes were dropped or merged."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract
from modallab.extraction.requested.selected_modes import DROPPED, select_modes
from modallab.extraction.requested.selection import ModeSelection
from modallab.fe.synthetic_modes import ModeNoise, synthetic_modes
from modallab.jobs import selecting
from modallab.jobs.selecting import selected_model
from modallab.jobs.settings import JOB
from modallab.rig.hardware import Accelerometers, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from tests.rigs import beam_system, rig, steel_beam

NODES = tuple(range(1, 22, 2))


@cache
def measured(mass: float = 0.0) -> Measurement:
    accelerometers = Accelerometers(mass=mass, roving=True)
    analyser = {"frequency_max": 250.0, "n_lines": 251}
    setup = rig(*NODES, analyser=analyser, accelerometers=accelerometers, noise=Noise(1e-3, 1e-3))
    return measure(steel_beam(), setup, route=Route.DRAWN, rng=np.random.default_rng(1))


@cache
def modes_of(method: str, mass: float = 0.0) -> ModalModel:
    test = measured(mass)
    return extract(test.frf, coherence=test.coherence, averages=test.averages, method=method)


def mac(a: np.ndarray, b: np.ndarray) -> float:
    return float(abs(np.vdot(a, b)) ** 2 / (np.vdot(a, a).real * np.vdot(b, b).real))


@pytest.mark.parametrize("method", ["dobson", "lscf"])
def test_a_dropped_mode_is_gone_and_the_others_are_as_they_were(method: str) -> None:
    model = modes_of(method)
    left = select_modes(model, ModeSelection(drop=(2,)))
    assert len(left.modes) == len(model.modes) - 1
    np.testing.assert_array_equal(left.frequencies, np.delete(model.frequencies, 1))
    np.testing.assert_array_equal(left.shapes, np.delete(model.shapes, 1, axis=1))
    assert left.modal_constant is not None
    assert len(left.modal_constant) == len(left.modes)
    assert [pole.frequency for pole in left.doubtful if pole.reason == DROPPED] == [model.frequencies[1]]
    assert left.choices["selection"] == "dropped 2: by request"
    if left.chart is not None:
        assert model.chart is not None
        moved = {-1: -1, 0: 0, 1: -1, 2: 1, 3: 2}
        assert left.chart.mode.tolist() == [moved[old] for old in model.chart.mode.tolist()]


def test_notes_follow_the_new_numbers() -> None:
    model = modes_of("lscf")
    left = select_modes(model, ModeSelection(drop=(1,)))
    for number, frequency in enumerate(left.frequencies, 1):
        (note,) = [note for note in left.notes if note.startswith(f"mode {number}, ")]
        assert note.startswith(f"mode {number}, {frequency:.5g} Hz")


def test_merged_poles_of_one_mode_have_its_shape_and_size() -> None:
    model = modes_of("lscf", 0.01)  # the roving mass splits modes 3 and 4
    pairs = tuple((n, n + 1) for n in range(1, len(model.modes)) if np.diff(model.frequencies)[n - 1] < 2.0)
    assert pairs
    merged = select_modes(model, ModeSelection(merge=pairs))
    exact = synthetic_modes(
        beam_system(), len(merged.modes), model.dofs, noise=ModeNoise(), rng=np.random.default_rng(0)
    ).shapes
    for mode, column in zip(merged.modes, exact.T, strict=True):
        # 10 g on 5.85 kg and its bend of the fits; each part alone has a MAC below 0.97
        assert mac(mode.shape, column) > 0.99
        assert np.linalg.norm(mode.shape) == pytest.approx(np.linalg.norm(column), rel=0.03)
        assert not any(flag.startswith(("pair", "doubled")) for flag in mode.flags)
    parts = [mac(model.modes[n - 1].shape, exact[:, pairs[-1][0] - len(pairs)]) for n in pairs[-1]]
    assert min(parts) < 0.97


def test_frfs_of_merged_single_mode_fits_keep_their_frequencies_and_lines() -> None:
    model = modes_of("dobson", 0.01)
    assert model.frequency_inconsistency is not None
    merged = select_modes(model, ModeSelection(merge=((2, 3),)))
    inconsistency = merged.frequency_inconsistency
    assert inconsistency is not None
    assert inconsistency.shift.shape == (len(merged.modes), len(model.frfs))
    assert merged.fitted_frequency is not None
    assert merged.fitted_lines is not None
    assert model.fitted_lines is not None
    np.testing.assert_allclose(inconsistency.shift[2], model.frequency_inconsistency.shift[3])
    np.testing.assert_array_equal(merged.fitted_lines[1, :, 0], model.fitted_lines[1:3, :, 0].min(axis=0))
    np.testing.assert_array_equal(merged.fitted_lines[1, :, 1], model.fitted_lines[1:3, :, 1].max(axis=0))


def test_the_misfit_is_that_of_the_modes_that_are_left() -> None:
    test, model = measured(), modes_of("lscf")
    same = selected_model(model, ModeSelection(drop=(len(model.modes),)), None)
    assert same.resynthesis_error is model.resynthesis_error  # nothing to compare with
    left = selected_model(model, ModeSelection(drop=(2,)), test)
    assert model.resynthesis_error is not None
    assert left.resynthesis_error is not None
    assert left.ranges == model.ranges
    # a mode of four is missing in the FRFs: no residual replaces a resonance
    assert left.resynthesis_error.max() > 0.3 > 10 * model.resynthesis_error.max()
    assert any(note.startswith("modes and residuals leave") for note in left.notes)


def test_a_later_selection_keeps_the_earlier_one() -> None:
    first = select_modes(modes_of("lscf"), ModeSelection(drop=(2,)))
    second = select_modes(first, ModeSelection(merge=((1, 2),)))
    assert second.choices["selection"] == "dropped 2, then merged 1 and 2: by request"


def test_many_values_are_not_fitted_again(monkeypatch: pytest.MonkeyPatch) -> None:
    test, model = measured(), modes_of("lscf")
    monkeypatch.setattr(selecting, "JOB", replace(JOB, refitted_values=test.frf.values.size - 1))
    left = selected_model(model, ModeSelection(drop=(2,)), test)
    assert left.resynthesis_error is model.resynthesis_error
    assert selecting.NOT_REFITTED in left.notes
