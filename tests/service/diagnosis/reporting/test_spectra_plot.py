"""Auto spectra in a report: drawn where they tell what the FRFs do not."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np

from modallab.core.place import EffectSpec
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.reporting.spectra_plot import spectra_drawings
from modallab.diagnosis.result_curves import Spectra
from modallab.rig.effect import build
from tests.diagnosed import curves
from tests.diagnosing import draw_measurement, model, rig


def spectra(factor: float) -> Spectra:
    """Return spectra of six runs, of which the fourth was predicted a factor too low."""
    flat = np.full((60, 6), 1e-3)
    off = flat.copy()
    off[:, 3] /= factor
    return Spectra(flat, off, flat, np.full((60, 6), 0.1))


def test_the_channel_that_is_furthest_off_is_drawn_level_above_difference() -> None:
    page = ET.fromstring(f"<div>{spectra_drawings(replace(curves(), force=spectra(1.5)), added=True)}</div>")
    (figure,) = page.iter("figure")
    words = " ".join(" ".join(figure.itertext()).split())
    assert "Force spectrum, response 5:+Y." in words
    assert "dB re 1 N²/Hz" in words
    level, difference = figure.iter("svg")
    assert {one.get("class") for one in level.iter("path")} >= {"measured", "before", "after"}
    # ln 1.5 over 0.1 is four random errors; what was added leaves none
    before = next(one for one in difference.iter("path") if one.get("class") == "before")
    after = next(one for one in difference.iter("path") if one.get("class") == "left")
    assert mean_height(before) < mean_height(after), "up is more"


def mean_height(path: ET.Element) -> float:
    """Return how far down a curve lies on average."""
    points = path.get("d", "").replace("M", "L").split("L")[1:]
    return float(np.mean([float(point.split(",")[1]) for point in points]))


def test_spectra_that_agree_or_were_not_measured_are_not_drawn() -> None:
    assert spectra_drawings(replace(curves(), force=spectra(1.0), incoherent=spectra(1.0)), added=True) == ""
    assert spectra_drawings(curves(), added=True) == ""


def test_an_undeclared_armature_shows_in_the_force_alone() -> None:
    test = draw_measurement(rig(), [build(EffectSpec("exciter_armature", None, {"mass": 0.05}))])
    found = diagnose(model(), test, suspects=["exciter_armature", "extra_mass"])
    force, incoherent = found.curves.force, found.curves.incoherent
    assert force is not None
    assert incoherent is not None
    assert force.measured.shape == incoherent.measured.shape == (161, 6)
    off = (np.log(force.measured / force.before)[1:] / force.random_error[1:]) ** 2
    left = (np.log(force.measured / force.after)[1:] / force.random_error[1:]) ** 2
    # a mean over 960 numbers of which each varies by sqrt 2: 1 within five times 0.046
    assert off.mean() > 3
    assert abs(left.mean() - 1) < 0.23
