"""What docs/updating.md tells to type."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

TEXT = (Path(__file__).parents[2] / "docs" / "updating.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def names() -> Iterator[dict[str, Any]]:
    """What the blocks leave behind, run one after the other."""
    left: dict[str, Any] = {}
    for block in re.findall(r"^```python\n(.*?)^```", TEXT, flags=re.DOTALL | re.MULTILINE):
        exec(block, left)
    yield left
    left["lab"].close()


def test_corrected_matrices_have_the_modes_that_were_used_and_others_are_told(names: dict[str, Any]) -> None:
    direct = names["direct"]
    assert direct.reproduced < 1e-8  # of shapes expanded to all DoFs the method is exact
    assert direct.connectivity_loss["stiffness"] > 0.1
    modes = names["modes"].frequencies[4:]
    assert len(direct.other_modes.after) >= len(modes)


def test_a_dof_near_the_stiffer_members_is_named_first(names: dict[str, Any]) -> None:
    assert names["located"].n_dofs == 42
    assert np.isfinite(names["error"])
    # members 11 and 12 run from node 11 to node 13; expanded rotations smear it over a neighbour
    assert 10 <= int(names["worst"].split(":")[0]) <= 14
