from pathlib import Path

import pytest

from benchmarks import sensitivity
from benchmarks.sensitivity import Study, Variation, applied, groups, read, report, varied


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
