import json
import shutil
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from pydantic import TypeAdapter

from benchmarks import sensitivity
from benchmarks.sensitivity import (
    GROUPED,
    Study,
    Variation,
    applied,
    foreign_case,
    groups,
    read,
    report,
    varied,
)
from modallab.api.rigs.schemas import RigIn
from modallab.api.structures.schemas import StructureIn
from modallab.core.dof import Dof
from modallab.core.place import EffectSpec
from modallab.rig.effect import build
from modallab.rig.measure import Route, measure


def test_all_settings_of_the_diagnosis_are_varied() -> None:
    assert any(name.startswith("diagnosis.") for name in groups())


@pytest.mark.parametrize(
    ("value", "unit", "factor", "expected"),
    [
        (3.0, "standard errors", 2.0, 6.0),
        (5, "lines", 0.5, 2),
        (1, "lines", 0.5, 1),
        (0.9, "probability", 2.0, 18 / 19),
        ((0.1, 1.0), "1", 0.5, (0.05, 0.5)),
        (True, "1", 2.0, True),
    ],
)
def test_a_probability_varies_in_odds_and_a_count_stays_whole(
    value: object, unit: str, factor: float, expected: object
) -> None:
    assert varied(value, unit, factor) == pytest.approx(expected)


def test_settings_are_as_before_after_a_variation() -> None:
    name, settings = next(iter(groups().items()))
    before = vars(settings).copy()
    with applied(Variation(name, "", "doubled")):
        assert vars(settings) != before
    assert vars(settings) == before


def test_a_run_that_was_cut_goes_on_and_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, str]] = []

    def answered(variation: Variation, which: tuple[str, int, int]) -> dict[str, object]:
        asked.append((str(variation), sensitivity.name_of(which)))
        right = variation.direction != "doubled" or which[2] != 0
        return {"case": sensitivity.name_of(which), "right": right, "seconds": 1.0} | vars(variation)

    monkeypatch.setattr(sensitivity, "answer", answered)
    monkeypatch.setattr(sensitivity, "ProcessPoolExecutor", _Inline)
    cases = [("1", 9001, 0), ("1", 9001, 1)]
    out = tmp_path / "answers.jsonl"
    doubled = Variation("diagnosis.SEARCH", "", "doubled")
    study = Study(cases, out, 1, deadline=float("inf"))
    study.run([Variation()])
    study.run([doubled])
    again = Study(cases, out, 1, deadline=float("inf"))
    again.run([Variation(), doubled])
    assert len(asked) == len(read(out)) == 4, "what is known is not asked again"
    assert again.compare(doubled) == (0, 1, 2)
    assert "| diagnosis.SEARCH doubled | 0 | 1 | 2 | 1 |" in report(again)


class _Inline:
    """Stands for a pool of processes; a task is done when it is submitted."""

    def __init__(self, workers: int) -> None: ...

    def __enter__(self) -> "_Inline":
        return self

    def __exit__(self, *_: object) -> None: ...

    def submit(self, function, *arguments):  # type: ignore[no-untyped-def]
        from concurrent.futures import Future

        task: Future[object] = Future()
        task.set_result(function(*arguments))
        return task


def test_one_group_is_varied_on_one_case(tmp_path: Path) -> None:
    name = next(iter(groups()))
    study = Study([("1", 9001, 0)], tmp_path / "answers.jsonl", 1, deadline=float("inf"))
    study.run([Variation(), Variation(name, "", "doubled")])
    assert study.compare(Variation(name, "", "doubled"))[2] == 1


def test_any_first_part_of_the_cases_is_a_sample_of_all_sets() -> None:
    assert len(set(GROUPED)) == 48
    for first in (6, 12, 24):
        of_sets = Counter(name for name, _, _ in GROUPED[:first])
        # 28, 8 and 12 of 48: each set within one case of its share
        assert all(abs(of_sets[name] - first * n / 48) <= 1 for name, n in {"1": 28, "2": 8, "3": 12}.items())


@pytest.fixture(scope="module")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with one case: a short beam that carries a mass, six lines and two responses."""
    beam: dict[str, object] = {
        "kind": "beam",
        "length": 0.6,
        "n_elements": 3,
        "section": {"area": 5e-4, "second_moment": 4.1667e-9},
        "material": {"modulus": 2.09e11, "density": 7800.0},
        "damping": {"law": "structural", "stiffness_coefficient": 0.02},
    }
    rig = {
        "drive": "1:+Y",
        "responses": ["1:+Y", "3:+Y"],
        "noise": {"force": 1e-3, "response": 1e-3},
        "analyser": {"frequency_max": 400.0, "n_lines": 81, "averages": 50},
    }
    case = tmp_path_factory.mktemp("foreign") / "case_1"
    case.mkdir()
    for name, body in (
        ("structure", beam),
        ("rig", rig),
        ("truth", {"effects": [{"kinds": ["extra_mass", "density_error"]}]}),
        ("tolerances", {"sensitivity": 0.001}),
    ):
        (case / f"{name}.json").write_text(json.dumps(body), encoding="utf-8")
    structure = TypeAdapter(StructureIn).validate_python(beam).to_domain()
    setup = TypeAdapter(RigIn).validate_python(rig).to_domain()
    hidden = build(EffectSpec("extra_mass", Dof(3, "Y"), {"mass": 0.3}))
    test = measure(structure, setup, [hidden], route=Route.DRAWN, rng=np.random.default_rng(3))
    assert test.coherence is not None
    np.savez(
        case / "measured.npz",
        freq=test.frf.freq,
        values=test.frf.values,
        coherence=test.coherence,
        averages=test.averages,
        outputs=[str(dof) for dof in test.frf.outputs],
        inputs=[str(dof) for dof in test.frf.inputs],
        kind=test.frf.kind,
    )
    return case.parent


def test_a_foreign_case_is_answered_from_its_folder(foreign: Path) -> None:
    line = foreign_case(Variation(), foreign / "case_1")
    assert (line["case"], line["right"]) == ("case_1", True)


def test_foreign_cases_alone_are_varied_and_one_that_fails_is_told(
    foreign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(foreign, tmp_path / "cases")
    (tmp_path / "cases" / "README").write_text("no case", encoding="utf-8")
    (tmp_path / "cases" / "case_2").mkdir()
    out = tmp_path / "answers.jsonl"
    places = ["--out", str(out), "--foreign", str(tmp_path / "cases")]
    sizes = ["--cases", "0", "--workers", "1", "--groups", "diagnosis.reporting.TERMINAL"]
    monkeypatch.setattr(sensitivity, "ProcessPoolExecutor", _Inline)
    monkeypatch.setattr(sys, "argv", ["sensitivity", *places, *sizes])
    sensitivity.main()
    printed = capsys.readouterr().out
    assert "1 of 2 cases are right with the settings as they are; 1 failed" in printed
    assert "2 of 2 variations changed no answer" in printed
    assert len(read(out)) == 6
