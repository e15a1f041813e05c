"""The pages of extraction methods: one each, with its picture, its numbers and its options."""

from pathlib import Path

import pytest
from PIL import Image

from docs.gallery.extracted import FOLDER, LOSS, METHODS, MODE, draw, model, numbers
from modallab.extraction.method_options import method_options
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS
from modallab.extraction.options import Damping

STALE = "run `make docs`"
GUIDE = (FOLDER.parent / "extraction.md").read_text(encoding="utf-8")


def written(method: str) -> str:
    path = FOLDER / f"{method}.md"
    assert path.exists(), "a page a method"
    return path.read_text(encoding="utf-8")


def test_there_is_a_page_for_every_method_and_no_other() -> None:
    assert {path.stem for path in FOLDER.glob("*.md")} == set(METHODS)
    assert {path.stem for path in FOLDER.glob("*.png")} == set(METHODS), STALE
    for method in METHODS:
        assert f"(extraction/{method}.md)" in GUIDE


@pytest.mark.parametrize("method", METHODS)
def test_a_page_has_derivation_use_options_and_source(method: str) -> None:
    text = written(method)
    for part in ("## Derivation", "## When", "## Sources", f"({method}.png)", "(../extraction.md)"):
        assert part in text, part
    (options,) = (line for line in text.splitlines() if line.startswith("Options: "))
    named = {word.strip("`.,;") for word in options.split() if word.startswith("`")}
    assert set(method_options(method)) == named


@pytest.mark.parametrize("method", METHODS)
def test_the_numbers_of_a_page_are_those_of_the_method(method: str) -> None:
    assert numbers(method) in written(method), STALE


@pytest.mark.parametrize("method", [m for m in METHODS if m != "peak_picking"])
def test_what_a_page_shows_is_right_within_its_standard_errors(method: str) -> None:
    mode = model(method).modes[MODE - 1]
    # three of them: chance exceeds that once in four hundred times, and the draw is the same each time
    assert abs(mode.loss_factor - LOSS) < 3 * mode.standard_errors["loss_factor"] + 5e-5  # neighbours' tails


@pytest.mark.parametrize("method", METHODS)
def test_a_picture_is_there_small_and_can_be_drawn(method: str) -> None:
    path: Path = FOLDER / f"{method}.png"
    assert path.stat().st_size < 60_000  # bytes: every clone carries them
    figure = draw(method)
    size = figure.get_size_inches() * 72
    with Image.open(path) as image:
        assert image.size == tuple(size.astype(int)), STALE
        assert len(set(image.convert("L").tobytes())) > 2, "something is drawn"
    assert all(axes.lines or axes.collections for axes in figure.axes)
    assert len(figure.axes) >= (2 if method in GLOBAL_METHODS else 3)


def test_the_guide_names_every_choice_and_every_flag() -> None:
    for option in ("lines", "leave_out", "max_order", "means"):
        assert f"| `{option}` |" in GUIDE
    for law in Damping:
        assert f"`{law}`" in GUIDE
    for flag in ("pair", "outlier", "node", "unsure", "complex shape"):
        assert f"`{flag}" in GUIDE
    for flag in ("leakage_bias", "damping_law", "window_damping"):
        assert f"`{flag}" in GUIDE
