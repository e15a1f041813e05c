"""What docs/rig.md tells to type."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.pages import DOCS, run_page

TEXT = (DOCS / "rig.md").read_text(encoding="utf-8")


def check(names: dict[str, Any]) -> None:
    """Compare what the blocks leave behind with what the guide says."""
    assert names["at_once"].values.shape == (201, 6, 2)
    assert names["struck"].values.shape == names["struck"].coherence.shape == (201, 1, 6)
    assert "exponential window" in names["struck"].notes[0]
    # an ideal rig's expected spectra have neither noise nor leakage
    np.testing.assert_allclose(names["test"].coherence, 1.0, atol=1e-9)
    assert names["receptance"].freq[0] == 2.0
    checks = {check["name"]: check["fulfilled"] for check in names["checks"]}
    assert set(checks) == {"suspension", "stinger_bending", "stinger_axial", "useful_range"}
    assert Path("mobility.uff").stat().st_size > 0
    lines = [
        line.split()
        for line in names["__printed__"].splitlines()
        if " sampled " in line or " expected " in line
    ]
    figures = {(float(level), route): (float(peak), float(g2)) for level, route, peak, g2 in lines}
    (expected, straight), (stepped, by_steps) = figures[1.0, "expected"], figures[1.0, "sampled"]
    # 1 % and two digits of coherence are the guide's words; the peak of 50 averages scatters by 0.9 % (four
    # tests of 200 averages: 28.85 with a standard error of 0.06, where 28.89 is expected)
    assert stepped == pytest.approx(expected, rel=0.018)
    assert (round(straight, 2), round(by_steps, 2)) == (0.93, 0.92)


def test_every_block_of_the_guide_runs_and_gives_what_the_guide_says(tmp_path: Path) -> None:
    run_page("rig.md", tmp_path, check)


def test_what_the_guide_points_to_is_there() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", TEXT):
        assert (DOCS / target).is_file(), target


def test_the_guide_names_every_check_and_every_field_of_a_rig() -> None:
    from modallab.api.rigs.analyser import AnalyserIn
    from modallab.api.rigs.schemas import RigIn

    for name in RigIn.model_fields:
        assert f"`{name}`" in TEXT or f"{name}=" in TEXT, name
    elsewhere = "".join(
        (DOCS / page).read_text(encoding="utf-8") for page in ("excitation.md", "acquisition.md")
    )
    for name in AnalyserIn.model_fields:
        assert name in TEXT or name in elsewhere, name
