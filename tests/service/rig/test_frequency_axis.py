"""A stretch of lines that does not start at 0 Hz: what a whole test has there."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modallab.core.errors import InvalidInputError
from modallab.rig.analyser import Analyser
from modallab.rig.chain import chain
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.expected import coarse_spectra, expected_spectra
from modallab.rig.hardware import Noise
from modallab.rig.measure import Route, measure
from tests.diagnosing import model, rig
from tests.rigs import beam_system
from tests.rigs import rig as beam_rig

CUT = Analyser(frequency_min=50.0, frequency_max=400.0, n_lines=141)


def test_lines_are_counted_from_the_first_one_kept() -> None:
    np.testing.assert_allclose(CUT.freq, 50.0 + 2.5 * np.arange(141), rtol=1e-15)  # rounding
    assert (CUT.spacing, CUT.record_length) == (2.5, 0.4)
    assert (CUT.baseband.n_lines, CUT.baseband.spacing, CUT.baseband.freq[20]) == (161, 2.5, 50.0)
    np.testing.assert_array_equal(CUT.baseband.lines_at(CUT.freq), np.arange(20, 161))


@given(
    highest=st.floats(1.0, 5000.0), n_lines=st.integers(21, 3201), first=st.integers(0, 9), cut=st.booleans()
)
def test_every_line_of_the_band_is_driven_whatever_the_rounding(
    highest: float, n_lines: int, first: int, cut: bool
) -> None:
    """400 times 502 Hz / 400 is below 502 Hz: the last line of a test was taken for one without force."""
    spacing = highest / (n_lines - 1)
    kept = Analyser(frequency_max=highest, n_lines=n_lines)
    if cut:
        kept = Analyser(
            frequency_min=first * spacing, frequency_max=highest, n_lines=n_lines - first
        ).baseband
    density = kept.source_density(kept.freq)
    assert density[1:].min() > 0.999 * density.max()
    assert kept.source_density(np.array([1.01 * highest])) < 1e-6 * density.max()


def test_a_first_line_between_those_of_a_record_is_refused_by_name() -> None:
    shifted = replace(CUT, frequency_min=51.0, frequency_max=401.0)
    with pytest.raises(InvalidInputError, match="no multiple of the spacing") as refused:
        _ = shifted.baseband
    assert refused.value.context["field"] == "frequency_min"


def test_a_frequency_on_no_line_is_refused_with_its_number() -> None:
    freq = CUT.freq.copy()
    freq[16] += 0.3
    with pytest.raises(InvalidInputError, match=r"line 17, 90.3 Hz") as refused:
        CUT.lines_at(freq)
    assert refused.value.context["field"] == "freq"


@pytest.mark.parametrize(
    "bounds", [{"frequency_min": 400.0}, {"n_lines": 1_000_001}, {"frequency_min": -1.0}]
)
def test_impossible_axes_are_refused(bounds: dict[str, Any]) -> None:
    with pytest.raises(InvalidInputError):
        replace(CUT, **bounds)


@pytest.mark.parametrize("route", Route)
@pytest.mark.parametrize(("kind", "window"), [("periodic_random", "rectangular"), ("random", "hann")])
def test_a_cut_test_is_the_whole_one_at_its_lines(route: Route, kind: str, window: str) -> None:
    whole = rig(kind=kind, window=window, averages=8)
    kept: dict[str, Any] = {"frequency_min": 50.0, "n_lines": 141}
    cut = replace(whole, analyser=replace(whole.analyser, **kept))
    all_lines, lines = (
        measure(model(), setup, route=route, rng=np.random.default_rng(1)) for setup in (whole, cut)
    )
    assert lines.frf.freq.tolist() == cut.analyser.freq.tolist()
    np.testing.assert_array_equal(lines.frf.values, all_lines.frf.values[20:])
    assert lines.coherence is not None
    assert all_lines.coherence is not None
    np.testing.assert_array_equal(lines.coherence, all_lines.coherence[20:])


SOME = np.r_[3, 20:31, 64:80:2, 100]


@pytest.mark.parametrize("noise", [0.0, 1e-3])
@pytest.mark.parametrize("window", ["rectangular", "hann"])
@pytest.mark.parametrize("kind", [name for name in EXCITATIONS if name != "impact"])
def test_spectra_at_some_lines_are_those_of_all(kind: str, window: str, noise: float) -> None:
    setup = beam_rig(1, 7, excitation=kind, analyser={"window": window, "n_lines": 101, "averages": 8})
    bench = chain(beam_system(), replace(setup, noise=Noise(noise, noise)))
    pairs = (
        (expected_spectra(bench, lines=SOME), expected_spectra(bench).at(SOME)),
        (coarse_spectra(bench, 4, np.arange(20, 64, 4)), coarse_spectra(bench, 4).at(np.arange(5, 16))),
    )
    for some, every in pairs:
        assert some.freq.tolist() == every.freq.tolist()
        for name in ("ff", "fx", "xx"):
            # the same sums in another order: rounding
            np.testing.assert_allclose(getattr(some, name), getattr(every, name), rtol=1e-9, err_msg=name)


def test_few_lines_are_solved_for_no_others(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = chain(beam_system(), beam_rig(1, 7, analyser={"window": "hann"}))
    solved: list[int] = []
    respond = type(bench)._responses

    def counted(self: object, freq: np.ndarray) -> object:
        solved.append(len(freq))
        return respond(self, freq)  # type: ignore[arg-type]

    monkeypatch.setattr(type(bench), "_responses", counted)
    expected_spectra(bench, lines=np.arange(100, 110))
    assert solved == [12]  # a Hann window takes in a neighbour on either side
