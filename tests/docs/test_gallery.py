"""The gallery of effects: whole, true to the classes, and every picture shows its effect."""

import io
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from docs.gallery.curves import TOUCH_LINES, Curve, Panel, Picture, merged, picture, rig_body, touched
from docs.gallery.drawing import SIZE, draw, drawn, png
from docs.gallery.example import structure
from docs.gallery.examples import example_of
from docs.gallery.pages import index, page, parameter_table
from docs.gallery.words import HARDWARE, SIMILAR_EFFECTS
from modallab.api.rigs.schemas import RigIn
from modallab.core.dof import Dof
from modallab.rig.effect import EFFECTS, Effect, build

KINDS = sorted(EFFECTS)
FOLDER = Path(__file__).parents[2] / "docs" / "effects"
STALE = "run `make docs`"
COARSE = TOUCH_LINES


def written(name: str) -> str:
    path = FOLDER / name
    assert path.exists(), STALE
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize("kind", KINDS)
def test_an_effects_page_says_what_its_class_says(kind: str) -> None:
    found = written(f"{kind}.md")
    assert parameter_table(EFFECTS[kind]) in found, STALE
    assert found == page(kind), STALE


@pytest.mark.parametrize("kind", KINDS)
def test_a_parameter_table_has_every_number_with_unit_bounds_default_and_absent(kind: str) -> None:
    rows = [
        line.split(" | ") for line in parameter_table(EFFECTS[kind]).splitlines() if line.startswith("| `")
    ]
    named = {row[0].strip("| `"): row[1:] for row in rows}
    assert list(named) == list(EFFECTS[kind].specs())
    for name, spec in EFFECTS[kind].specs().items():
        meaning, unit, *numbers, absent = (cell.rstrip(" |") for cell in named[name])
        assert (meaning, unit) == (spec.doc, spec.unit)
        wanted = [getattr(EFFECTS[kind](at=None), name), spec.lower, spec.upper]
        # six digits are printed
        np.testing.assert_allclose([float(number) for number in numbers], wanted, rtol=1e-5)
        assert absent == "-" if spec.absent is None else float(absent) == pytest.approx(spec.absent)


@pytest.mark.parametrize("kind", KINDS)
def test_a_page_has_an_equation_and_its_source(kind: str) -> None:
    said = EFFECTS[kind].__doc__ or ""
    assert re.search(r"[^`]=", said), "an equation in the class's docstring"
    sources = (
        r"\b1[89]\d\d\b|\b20\d\d\b|ISO \d+|\[(\d|[A-Z])\.\d+"  # a year, a standard, the thesis's numbers
    )
    assert re.search(sources, said), "its source in the class's docstring"


def test_the_front_page_shows_every_effect_once_and_no_other() -> None:
    found = written("README.md")
    assert found == index(), STALE
    assert sorted(re.findall(r'src="(\w+)\.png"', found)) == KINDS
    assert {path.stem for path in FOLDER.glob("*.*")} == {*KINDS, "README"}, STALE


@pytest.mark.parametrize("kind", KINDS)
def test_a_picture_is_there_and_small(kind: str) -> None:
    path = FOLDER / f"{kind}.png"
    assert path.exists(), STALE
    with Image.open(path) as image:
        assert image.size == (640, 480)
        assert len(set(image.convert("L").tobytes())) > 2, "something is drawn"
    assert path.stat().st_size <= 20_480  # bytes: every clone carries them


def test_all_pictures_together_are_no_burden() -> None:
    assert sum(path.stat().st_size for path in FOLDER.glob("*.png")) < 800_000  # bytes


@pytest.mark.parametrize("kind", KINDS)
def test_a_picture_can_be_drawn_and_the_effect_seen_in_it(kind: str) -> None:
    whole = picture(kind, COARSE)
    # at least one panel changes by 0.2 dB, a degree or 0.01 of coherence
    assert any(whole.visible(panel) for panel in whole.panels), "show it where it shows"
    figure = drawn(whole)
    assert len(figure.axes) == len(whole.panels)
    for axes in figure.axes:
        assert len(axes.lines) == 1 + len(whole.curves)
        assert axes.get_ylabel()
        assert all(np.isfinite(np.asarray(line.get_ydata(), float)).any() for line in axes.lines)


def test_a_picture_without_the_effect_shows_no_change() -> None:
    whole = picture("extra_mass", COARSE)
    same = replace(whole, curves=(Curve("with", whole.reference, whole.reference),))
    assert not any(same.visible(panel) for panel in same.panels)


def test_what_an_effect_touches_is_what_theory_says() -> None:
    # the force on the structure falls and rises, and the response with it; the ratio stays
    assert touched("exciter_armature") == ("force", "response")
    assert touched("polarity") == ("phase",)
    assert touched("channel_delay") == ("phase",)
    assert touched("gain_error") == ("magnitude", "response")
    # of H1, which noise on the response does not bias
    assert touched("response_noise") == ("coherence", "response")


def test_half_a_turn_is_the_largest_change_of_phase() -> None:
    whole = picture("polarity", COARSE)
    # -1 turns by 180 degrees, whichever side of the cut its phase comes out
    assert whole.change(Panel("phase", Dof(7, "Y"))) == pytest.approx(180.0, abs=1e-6)


def test_the_same_picture_has_the_same_bytes() -> None:
    first, second = (png(draw("gain_error", COARSE)) for _ in range(2))
    assert first == second
    with Image.open(io.BytesIO(first)) as image:
        assert image.size == tuple(round(100 * inches) for inches in SIZE)


def test_an_effect_that_nobody_described_is_shown_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("docs.gallery.examples.GROUPS", {})
    whole: Picture = picture.__wrapped__("extra_mass", COARSE)  # past what is remembered
    assert whole.visible(whole.panels[0])
    assert "extra_mass.png" in page("extra_mass")


def implied(kind: str, parts: Any) -> list[str]:
    setup = RigIn.model_validate({"drive": "1:+Y", "responses": ["7:+Y"], **parts}).to_domain()
    return [effect.kind for effect in EFFECTS[kind].from_setup(setup)]


@pytest.mark.parametrize("kind", KINDS)
def test_hardware_that_a_page_declares_implies_the_effect(kind: str) -> None:
    function = EFFECTS[kind].from_setup.__func__  # type: ignore[attr-defined]
    by_hardware = function is not Effect.from_setup.__func__  # type: ignore[attr-defined]
    assert by_hardware == (kind in HARDWARE), "an entry in docs/gallery/words.py, as from_setup has it"
    if by_hardware:
        assert kind in implied(kind, HARDWARE[kind])
        assert implied(kind, {}) == []


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_page_gives_to_copy_is_accepted(kind: str) -> None:
    example = example_of(kind)
    for text in re.findall(r"```json\n(.*?)\n```", page(kind)):
        setup = RigIn.model_validate(merged(rig_body(example), json.loads(text))).to_domain()
        for spec in setup.effects:
            assert spec.kind == kind
            build(spec).check(structure(example.structure), setup)


def test_every_word_about_look_alikes_names_effects_there_are() -> None:
    assert set(SIMILAR_EFFECTS) >= set(KINDS)
    for kind, said in SIMILAR_EFFECTS.items():
        for other in re.findall(r"`(\w+)`", said):
            assert other in KINDS, f"{kind} names {other}"
