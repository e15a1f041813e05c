"""What docs/client.md tells to type."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modallab_client import load
from tests.pages import DOCS, run_page


def check(names: dict[str, Any]) -> None:
    """Compare pictures, files and tables with what the page says of them."""
    guide = (DOCS / "client.md").read_text(encoding="utf-8")
    calls = re.findall(r"^\| `((?:layout|test|modes)\.[^`]*)`", guide, re.MULTILINE)
    assert calls
    for call in calls:
        assert eval(call, names) is not None
    assert {path.name for path in Path().iterdir()} == {"mode-2.gif", "mode-2.png", "modes.npz"}
    assert load("modes.npz").table() == names["modes"].table()
    assert names["modes"].table() in names["__printed__"]
    assert names["table"].frequency[2] == names["modes"].modes[1].frequency
    assert float(names["frfs"].coherence.sel(output="7:+Y", freq=100.0)) == pytest.approx(1.0)
    np.testing.assert_array_equal(names["again"].values, names["test"].values)


def test_the_blocks_make_what_the_page_says(tmp_path: Path) -> None:
    run_page("client.md", tmp_path, check)
