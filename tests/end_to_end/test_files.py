"""What docs/files.md tells to type."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modallab_client import errors
from tests.pages import blocks, run_page


def check(names: dict[str, Any]) -> None:
    """Compare what the blocks leave behind with what was exported and read."""
    lab, made = names["lab"], names["made"]
    direct = lab.modal_models.start(made.id, method="dobson", n_modes=8).result()
    assert len(direct.modes) == 8
    assert names["modes"].table() == direct.table()
    np.testing.assert_array_equal(names["modes"].shapes, direct.shapes)
    # the header says which thing a file is of
    first, again = (Path(name).read_bytes() for name in ("frf.uff", "out.uff"))
    assert again[again.index(b"    58b") :] == first[first.index(b"    58b") :]
    # columns of 13 leave six digits
    np.testing.assert_allclose(names["same"].shapes, direct.shapes, rtol=1e-5, atol=1e-9)
    assert Path("geometry.uff").read_bytes().count(b"\n    82\n") == 1
    size = np.abs(made.values).max()
    # g/N and back: rounding
    np.testing.assert_allclose(names["from_matlab"].values[:, :, 0], made.values[:, :, 0], atol=1e-12 * size)
    assert names["from_text"].outputs == ("12:+Z", "3:-Z")
    with pytest.raises(errors.InvalidInputError, match="dataset"):
        lab.measurements.upload(first[:-1000], names["rig"].id)


def test_the_examples_run_and_a_universal_file_gives_modes_in_two_lines(tmp_path: Path) -> None:
    assert [len(block.splitlines()) for block in blocks("files.md")][1] == 2
    run_page("files.md", tmp_path, check)
