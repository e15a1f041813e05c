"""What docs/client.md tells to type."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modallab_client import load
from tests.pages import DOCS, outcomes


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
    # the same numbers, computed from the same seed: to the last bit
    np.testing.assert_array_equal(names["same_test"].values, names["test"].values)


def check_other_programs(names: dict[str, Any]) -> None:
    """Compare what goes to other programs and comes back with the test."""
    test = names["test"]
    assert names["frf"].shape == (len(test.outputs), len(test.freq))
    np.testing.assert_array_equal(names["from_rows"], test.values)
    assert names["ordinate"].shape == (*test.values.shape[1:], len(test.freq))
    assert names["node"][:, 0, 0].tolist() == list(range(1, 22, 2))
    assert names["direction"].tolist() == [[[2, 2]]] * 11
    assert names["numbered"]("12:-Z") == (12, -3)
    assert names["dof"]("12Z-") == "12:-Z"
    np.testing.assert_array_equal(names["values"], test.values)
    table = names["df_chn"].set_index("Name")
    assert table.loc["7:+Y", ["Direction_1", "Direction_2", "Direction_3"]].tolist() == [0, 1, 0]
    assert table.Position_1.tolist() == [
        names["layout"].nodes[int(dof.split(":")[0])][0] for dof in test.outputs
    ]
    assert names["channels"](["7:-Y"]).Direction_2.tolist() == [-1]


def test_the_blocks_make_what_the_page_says(tmp_path: Path) -> None:
    failures = outcomes("client.md", tmp_path, [check, check_other_programs])
    assert not any(failures.values()), "\n".join(failures.values())
