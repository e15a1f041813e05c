"""Which stretch of which curve is worth an enlargement."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np

from modallab.diagnosis.reporting.figures import all_curves, enlarged, largest_difference
from modallab.diagnosis.reporting.settings import REPORT
from tests.diagnosed import curves


def test_the_enlargement_is_of_a_held_out_response_about_the_resonance() -> None:
    found = curves(401)
    shown = largest_difference(found)
    assert shown is not None
    channel, lines = shown
    assert found.held_out[channel]
    assert found.freq[lines[0]] < 120 < found.freq[lines[-1]]
    assert len(lines) < 401 / 3


def test_a_fault_of_a_fitted_channel_alone_is_enlarged_where_it_is() -> None:
    found = replace(curves(), before=curves().after)  # only 5:+Y is off, by its factor, and was fitted
    shown = largest_difference(found)
    assert shown is not None
    assert shown[0] == 3


def test_curves_that_agree_are_not_enlarged() -> None:
    found = curves()
    same = replace(found, measured=found.after, before=found.after)
    assert largest_difference(same) is None
    assert enlarged(same, added=False) == ""


def test_an_enlargement_of_many_lines_has_no_more_dots_than_can_be_seen() -> None:
    shown = largest_difference(curves(60_001))
    assert shown is not None
    assert len(shown[1]) <= 2 * REPORT.most_lines + 1


def test_magnitude_phase_and_difference_stand_above_each_other_with_units() -> None:
    page = ET.fromstring(f"<div>{all_curves(curves(), added=True)}</div>")
    first = next(page.iter("figure"))
    labels = [[t.text for t in one.iter("text") if t.get("class") == "label"] for one in first.iter("svg")]
    assert labels == [["dB re 1 m/(s² N)"], ["phase, degrees"], ["frequency, Hz", "random errors"]]


def test_without_additions_nothing_is_drawn_as_added() -> None:
    page = ET.fromstring(f"<div>{all_curves(curves(), added=False)}</div>")
    assert not [one for one in page.iter("path") if one.get("class") in ("after", "left")]


def test_a_phase_does_not_jump_across_the_drawing() -> None:
    # a resonance's phase passes 180 degrees: the curve breaks there
    found = curves()
    turned = replace(found, measured=found.measured * np.exp(0.02j), random_error=found.random_error)
    page = ET.fromstring(f"<div>{all_curves(turned, added=True)}</div>")
    for drawing in page.iter("svg"):
        if "phase" not in drawing.get("aria-label", ""):
            continue
        for path in (one for one in drawing.iter("path") if one.get("class") in ("measured", "before")):
            for piece in path.get("d", "").split("M")[1:]:
                heights = [float(point.split(",")[1]) for point in piece.split("L")]
                assert np.abs(np.diff(heights)).max(initial=0) < 50  # 180 of 380 degrees in 90 units


def test_a_noisy_phase_about_180_degrees_stays_in_one_piece() -> None:
    found = curves()
    scatter = np.random.default_rng(1).normal(0, 0.1, found.measured.shape)
    opposite = replace(found, measured=-np.abs(found.measured) * np.exp(1j * scatter))
    page = ET.fromstring(f"<div>{all_curves(opposite, added=True)}</div>")
    phases = [one for one in page.iter("svg") if "phase" in one.get("aria-label", "")]
    paths = [path for drawing in phases for path in drawing.iter("path") if path.get("class") == "measured"]
    assert paths
    assert all(path.get("d", "").count("M") == 1 for path in paths)


def test_a_difference_that_no_curve_shows_is_drawn_as_a_ratio_in_per_cent_and_degrees() -> None:
    found = curves(401)
    delayed = found.after.copy()
    delayed[:, 3] *= 1.05 * np.exp(-2j * np.pi * found.freq[:, None] * 1e-4)  # 5 % high and 0.1 ms late
    slight = replace(found, measured=delayed, before=found.after, after=delayed)
    page = ET.fromstring(f"<div>{enlarged(slight, added=True)}</div>")
    size, turn = page.iter("svg")
    labels = [one.text for svg in (size, turn) for one in svg.iter("text") if one.get("class") == "label"]
    assert labels == ["frequency, Hz", "magnitude, %", "frequency, Hz", "phase, degrees"]
    down = [float(one.get("cy", 0)) for one in turn.iter("circle")]
    assert len(down) <= 200
    assert (np.diff(down) >= 0).all(), "the phase falls with frequency"
    assert "Response 5:+Y / 1:+Y: measured over initial prediction." in "".join(page.itertext())


def test_the_axis_leaves_out_lines_without_power_of_the_source() -> None:
    found = curves(401)
    silent = found.freq < 10
    error = np.where(silent[:, None, None], 10.0, found.random_error)
    before, after = (np.where(silent[:, None, None], 1e-12, part) for part in (found.before, found.after))
    cut_band = replace(found, random_error=error, before=before, after=after)

    def ticks(picture: str) -> list[float]:
        texts = [element.text or "" for element in ET.fromstring(f"<p>{picture}</p>").iter() if element.text]
        return [float(text) for text in texts if text.lstrip("-").isdigit()]

    assert min(ticks(all_curves(cut_band, added=True))) == min(ticks(all_curves(found, added=True)))
