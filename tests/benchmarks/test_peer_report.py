"""The page of the speed beside another program has every figure that was measured, and how."""

import sys
from pathlib import Path

import pytest

from benchmarks import peer_report

ROWS = [("chart, over P", 0.94, 1.5), ("modes missed", 0.0, 0.0)]


def test_the_page_has_every_figure_with_its_limit() -> None:
    text = peer_report.page(ROWS, "0.31.0", "2 cores", 6.2, "2026-01-01")
    assert "| chart, over P | 0.94 | 1.5 |\n| modes missed | 0 | 0 |" in text
    assert "2 cores, 6.2 processes at work before" in text
    assert "sdypy-EMA 0.31.0" in text


def test_no_page_is_written_of_several_threads(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    monkeypatch.setattr(sys, "argv", ["peer_report", "--write", str(tmp_path / "speed.md")])
    with pytest.raises(SystemExit, match="2"):
        peer_report.main()
    assert "OPENBLAS_NUM_THREADS=1" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
