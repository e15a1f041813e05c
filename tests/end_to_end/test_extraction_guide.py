"""What docs/extraction.md tells to type."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff

from modallab_client import ModalLab
from tests.pages import DOCS, blocks, run_page

KNOWN = np.array([23.6, 65.1, 127.6])
LOSS = 0.02
SHAPES = np.array([[1.1, 1.1, 1.1], [-0.7, 0.1, 0.7], [1.1, -1.1, 1.1]])  # 1/sqrt(kg)
DIRECTION_Y = 2


def write_foreign(path: Path, freq: Any) -> None:
    """Write receptances with a library that is not ours, as any analyser's program might."""
    file = pyuff.UFF(str(path))
    eigenvalue = (2 * np.pi * KNOWN) ** 2 * (1 + 1j * LOSS)
    poles = 1 / (eigenvalue - (2 * np.pi * freq[:, None]) ** 2)
    for node, shape in zip((1, 5, 9), SHAPES, strict=True):
        values = (poles * shape * SHAPES[0]).sum(axis=1)
        dataset = pyuff.prepare_58(
            func_type=4,
            rsp_node=node,
            rsp_dir=DIRECTION_Y,
            ref_node=1,
            ref_dir=DIRECTION_Y,
            data=values,
            x=freq,
            id1=f"point {node}",
            rsp_ent_name="beam",
            ref_ent_name="beam",
            abscissa_spacing=1,
            ordinate_spec_data_type=8,
            orddenom_spec_data_type=13,
        )
        file.write_sets(dataset, "add")


def test_a_foreign_universal_file_gives_modes_in_two_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_foreign(tmp_path / "frf.uff", np.linspace(0.0, 200.0, 801))
    recipe = blocks("extraction.md")[1]
    assert len(recipe.splitlines()) == 2
    with ModalLab.embedded() as lab:
        names: dict[str, Any] = {"lab": lab}
        exec(recipe, names)
    modes = names["modes"]
    # exact lines of nothing but these modes: what the rounds of taking neighbours off leave
    np.testing.assert_allclose(modes.frequencies, KNOWN, rtol=1e-4)
    np.testing.assert_allclose(modes.loss_factors, LOSS, rtol=1e-2)
    np.testing.assert_allclose(modes.shapes.real, SHAPES, atol=0.02)
    assert modes.dofs == ("1:+Y", "5:+Y", "9:+Y")


def check(names: dict[str, Any]) -> None:
    """Compare what the blocks leave behind with what the page says."""
    lab = names["lab"]
    exact = lab.structures.modes(lab.structures.catalogue("chapter-5-beam").id, 3).frequencies
    # no noise: what neighbours outside the band leave
    np.testing.assert_allclose(names["modes"].frequencies, exact, rtol=1e-4)
    # one fit over the whole band: rigid bodies and modes above it are in its residual terms in part
    np.testing.assert_allclose(names["together"].frequencies, exact, rtol=5e-4)
    assert names["known"].averages == 50
    assert len(names["circles"].modes) == 2
    assert names["fewer"].choices["leave_out"] == "4: as requested"
    wander = names["moved"].frequency_inconsistency
    assert wander.cause == "roving_mass"
    assert abs(wander.size - 0.02) < 3 * wander.size_error
    assert len(names["whole"].modes) == 8 < len(names["split"].modes)


def test_the_examples_run_and_give_what_the_page_says(tmp_path: Path) -> None:
    run_page("extraction.md", tmp_path, check)


def test_what_the_guide_points_to_is_there() -> None:
    for page in (DOCS / "extraction.md", *sorted((DOCS / "extraction").glob("*.md"))):
        for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).is_file(), (page.name, target)
