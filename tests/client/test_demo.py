"""The demo: what it hides, what it says of it, and one whole run."""

import re
from pathlib import Path
from typing import Any

import pytest

from modallab_client import results
from modallab_client._read import read_as
from modallab_client.demo import hidden, thesis
from modallab_client.demo.__main__ import main
from modallab_client.demo.comparison import ComparisonTable, Line
from tests.client.fake import completed


def found(*effects: dict[str, Any], alike: tuple[dict[str, Any], ...] = ()) -> results.Diagnosis:
    """Return a diagnosis that named these effects."""
    steps = [
        {"effect": effect, "probability": 0.99, "gap_before": 50.0, "gap_after": 1.0, "rivals_alike": alike}
        | {"held_out_gap_before": 40.0, "held_out_gap_after": 1.1, "held_out_scatter": 0.1}
        for effect in effects
    ]
    reply = {"id": "d", "verdict": "explained", "steps": steps, "remaining_gap": 1.0}
    entry = {"created": "", "version": "", "structure_id": "s", "rig_id": "r"}
    return read_as(results.Diagnosis, completed(results.Diagnosis, reply | entry))


def effect(kind: str, at: str | None, **parameters: dict[str, Any]) -> dict[str, Any]:
    """Return an effect as a reply has it."""
    return {"kind": kind, "at": at, "parameters": parameters}


TRUTH = hidden.Hidden("extra_mass", "9:+Y", "mass", 0.05, "kg")
RIGHT = effect("extra_mass", "9:+Y", mass={"value": 0.0501, "standard_error": 4e-5, "unit": "kg"})
WRONG = effect("leakage", None, share={"value": 0.1, "standard_error": None, "unit": "1"})


def test_the_same_seed_hides_the_same_and_all_kinds_get_their_turn() -> None:
    assert hidden.draw(7) == hidden.draw(7)
    # 200 draws of 9 kinds: the chance that one is left out is 9 (8/9)^200, 1e-9
    drawn = [hidden.draw(seed) for seed in range(200)]
    assert {one.kind for one in drawn} == set(hidden.SUSPECTS)
    for one in drawn:
        suspect = hidden.SUSPECTS[one.kind]
        size = 1 / one.value if one.value < 1 and suspect.parameter == "factor" else one.value
        assert suspect.lower <= size <= suspect.upper


@pytest.mark.parametrize(
    ("diagnosis", "words"),
    [
        (found(RIGHT), "It was named first."),
        (found(WRONG), "It was not named."),
        (found(), "It was not named."),
        (found(WRONG, RIGHT), "It was named, but not first."),
        (
            found(RIGHT, alike=({"kind": "accelerometer_mass", "at": None},)),
            "It was named first; this test cannot tell it from accelerometer mass.",
        ),
        (
            found(WRONG, alike=({"kind": "extra_mass", "at": "9:+Y"},)),
            "It is among those that this test cannot tell from the one named first.",
        ),
    ],
)
def test_the_demo_is_honest_about_what_was_named(diagnosis: results.Diagnosis, words: str) -> None:
    assert hidden.outcome(TRUTH, diagnosis) == words


def test_an_effect_is_said_with_place_size_and_error() -> None:
    assert (
        hidden.sized(read_as(results.FittedEffect, RIGHT))
        == "extra mass at 9:+Y, mass 0.050100 ± 0.000040 kg"
    )
    assert hidden.sized(read_as(results.FittedEffect, WRONG)) == "leakage, share 0.1"
    assert hidden.closed(found(RIGHT).steps[0]) == ("50 → 1", "40 → 1.1")


@pytest.mark.parametrize(
    ("diagnosis", "words"),
    [
        (found(RIGHT), "Its mass is 0.2 % off the hidden 0.05, which is 2.5 standard errors."),
        (found(WRONG), ""),
        (found(), ""),
    ],
)
def test_the_size_is_held_against_the_truth(diagnosis: results.Diagnosis, words: str) -> None:
    assert hidden.compared(TRUTH, diagnosis) == words


def test_a_table_has_the_lab_above_the_thesis() -> None:
    table = ComparisonTable("Table", (Line("f & g, Hz", (22.96, 62.5), thesis.MEASURED[:2], 1),), "a note")
    assert table.text().splitlines()[2:] == [
        "f & g, Hz     lab  23.0  62.5",
        "           thesis  23.0  62.5",
        "a note",
    ]
    assert "f &amp; g" in table.html()


def test_a_negative_seed_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--seed", "-1"])
    assert "not negative" in capsys.readouterr().err


def test_a_missing_extra_is_named_before_anything_starts(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("modallab_client.demo.__main__.find_spec", lambda _name: None)
    with pytest.raises(SystemExit):
        main([])
    assert "pip install 'modallab[plot]'" in capsys.readouterr().err


def test_the_demo_reproduces_the_thesis_names_the_hidden_effect_and_writes_one_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["--out", str(tmp_path / "out")])
    told = capsys.readouterr().out
    for number in ("5.4", "5.5", "5.6", "5.7"):
        assert f"Table {number}: " in told
    before = told[told.index("Table 5.5") : told.index("Table 5.6")]
    model, printed = (line.split()[-8:] for line in before.splitlines()[4:6])
    assert model == printed  # the analytical frequencies, to the printed digit
    assert "suspected elements: 4 for mass (4), 12 for stiffness (12)" in told
    assert "It was named first" in told
    assert "Now the truth. Hidden was:" in told
    assert re.search(r"Its \w+ is .* % off the hidden", told)
    assert str((tmp_path / "out" / "report.html").resolve()) in told
    assert "<h1>Explained" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    page = (tmp_path / "out" / "demo.html").read_text(encoding="utf-8")
    assert str((tmp_path / "out" / "demo.html").resolve()) in told
    # all of it in the page: images as data, the report as a document within it
    assert not re.search(r"(?:src|href)='(?!data:)|<script|@import", page)
    assert page.count("<img") == 7
    assert "srcdoc=" in page
