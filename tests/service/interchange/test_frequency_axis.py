"""Frequency axes of files: any stretch of evenly spaced lines, with holes or from 0 Hz."""

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.interchange.frequency_axis import analyser_of, lines_on
from modallab.rig.analyser import Analyser

CUT = np.arange(50.0, 120.0, 0.25)


def test_a_stretch_of_lines_is_its_own_axis() -> None:
    analyser, notes = analyser_of(CUT, 10.0)
    assert (analyser.frequency_min, analyser.frequency_max, analyser.n_lines) == (50.0, 119.75, 280)
    assert analyser.averages == 10
    assert notes == ()


def test_lines_from_the_first_above_rest_are_those_of_a_whole_record() -> None:
    analyser, notes = analyser_of(np.arange(1.0, 401.0) * 0.5, 10.0)
    assert (analyser.frequency_min, analyser.n_lines, analyser.spacing) == (0.0, 401, 0.5)
    assert notes == ()


@pytest.mark.parametrize("missing", [np.r_[10:14], np.r_[1:280:2]], ids=["a few", "every other"])
def test_missing_lines_are_said(missing: np.ndarray) -> None:
    freq = np.delete(CUT, missing[missing != 3])  # one pair of neighbours shows the spacing
    analyser, notes = analyser_of(freq, 10.0)
    assert analyser.n_lines == (280 if 279 not in missing else 279)
    assert len(notes) == 1
    assert notes[0].startswith(f"{analyser.n_lines - len(freq)} of {analyser.n_lines} lines")


def test_an_uneven_line_is_named() -> None:
    freq = CUT.copy()
    freq[17] += 0.1
    _, notes = analyser_of(freq, 10.0)
    assert "line 18, 54.35 Hz" in notes[0]


def test_a_first_line_between_those_of_a_record_is_said() -> None:
    _, notes = analyser_of(CUT + 0.1, 10.0)
    assert "no multiple of the spacing" in notes[0]


def test_rounded_frequencies_are_even() -> None:
    analyser, notes = analyser_of((50 + np.arange(51_201) / 64).astype(np.float32).astype(float), 10.0)
    assert (analyser.n_lines, notes) == (51_201, ())


def test_a_million_lines_fit_and_one_more_does_not() -> None:
    assert analyser_of(1000 + np.arange(1_000_000) / 256, 1.0)[0].n_lines == 1_000_000
    with pytest.raises(InvalidInputError) as refused:
        analyser_of(1000 + np.arange(1_000_001) / 256, 1.0)
    assert refused.value.context["field"] == "freq"


def test_two_clusters_far_apart_are_no_analysers_lines() -> None:
    with pytest.raises(InvalidInputError) as refused:
        analyser_of(np.concatenate([np.arange(100) * 1e-4 + 1, np.arange(100) * 1e-4 + 1e4]), 1.0)
    assert refused.value.context["field"] == "freq"


def test_a_file_may_hold_part_of_the_analysers_lines() -> None:
    analyser = Analyser(frequency_max=200.0, n_lines=801)
    np.testing.assert_array_equal(lines_on(analyser, CUT * (1 + 1e-7), 1e-6), CUT)


@pytest.mark.parametrize(
    ("freq", "words"),
    [
        pytest.param(CUT[::2], "not the analyser's", id="twice the spacing"),
        pytest.param(CUT + 0.05, "line 1, 50.05 Hz", id="off the lines"),
        pytest.param(CUT + 100.0, "line 202, 200.25 Hz", id="beyond the band"),
    ],
)
def test_other_lines_than_the_analysers_are_refused(freq: np.ndarray, words: str) -> None:
    with pytest.raises(InvalidInputError, match=words) as refused:
        lines_on(Analyser(frequency_max=200.0, n_lines=801), freq, 1e-6)
    assert refused.value.context["field"] == "freq"
