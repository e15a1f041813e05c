"""What docs/correlation.md tells to type."""

import re
from pathlib import Path
from typing import Any

import pytest

from tests.pages import DOCS, run_page

TEXT = (DOCS / "correlation.md").read_text(encoding="utf-8")


def check(names: dict[str, Any]) -> None:
    """Compare what the blocks leave behind with what the guide says."""
    assert "9:+Y" in names["__printed__"].splitlines()
    assert names["found"].responses.frequency_scale == pytest.approx(1.10, abs=0.005)  # two digits are said
    flagged = [mode for mode in names["expanded"].model.modes if "doubtful_expansion" in mode.flags]
    assert (len(flagged), len(names["expanded"].model.modes)) == (6, 7)
    assert max(names["expanded"].fit_residuals) > 0.1


def test_every_block_of_the_guide_runs_and_gives_what_the_guide_says(tmp_path: Path) -> None:
    run_page("correlation.md", tmp_path, check)


def test_what_the_guide_points_to_is_there() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", TEXT):
        assert (DOCS / target).is_file(), target
