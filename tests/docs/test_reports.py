"""The reports that are made to be looked at."""

from pathlib import Path

import pytest

from docs.gallery import reports
from modallab.rig.effect import build


@pytest.mark.parametrize("name", reports.CASES)
def test_what_a_case_hides_can_be_in_its_test(name: str) -> None:
    case = reports.CASES[name]
    for spec in case.hidden:
        build(spec).check(reports.structure(), reports.rig(case))


def test_at_least_ten_kinds_are_shown() -> None:
    assert len({spec.kind for case in reports.CASES.values() for spec in case.hidden}) >= 10


def test_a_page_is_written_for_a_case(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    reports.main(tmp_path, ["nothing"])
    assert "Nothing is missing that this test can show." in (tmp_path / "nothing.html").read_text(
        encoding="utf-8"
    )
    assert "nothing.html" in capsys.readouterr().out
