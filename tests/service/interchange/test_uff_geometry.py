"""A structure's geometry as pyuff reads it."""

from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyuff

from modallab.fe.catalogued import STRUCTURES
from modallab.fe.structure import Member, Structure
from modallab.interchange import uff_geometry
from modallab.interchange.uff_text import Origin
from tests.rigs import BAR, STEEL, steel_beam


def sets_of(structure: Structure, folder: Path, origin: Origin = Origin()) -> list[Any]:  # noqa: B008
    """Return the datasets that pyuff finds in what is written."""
    (folder / "geometry.uff").write_bytes(uff_geometry.write(structure, origin))
    return list(pyuff.UFF(str(folder / "geometry.uff")).read_sets())


def drawn(lines: list[Any]) -> set[frozenset[int]]:
    """Return the pairs of nodes between which trace lines draw."""
    strokes = (pairwise(int(node) for node in line["nodes"]) for line in lines)
    return {frozenset(pair) for stroke in strokes for pair in stroke if 0 not in pair}


def test_nodes_are_where_the_structure_has_them(tmp_path: Path) -> None:
    for name in ("bay", "garteur", "chapter-5-beam"):
        structure = STRUCTURES[name]()
        _, units, nodes, *_ = sets_of(structure, tmp_path)
        assert (units["length"], nodes["type"]) == (1.0, 15)
        assert [int(number) for number in nodes["node_nums"]] == list(structure.nodes)
        places = np.array(list(structure.nodes.values()))
        # columns of 13 leave nine digits of a metre
        np.testing.assert_allclose(np.transpose([nodes["x"], nodes["y"]]), places[:, :2], atol=1e-9)


def test_trace_lines_draw_every_member_and_nothing_else(tmp_path: Path) -> None:
    for name in ("bay", "garteur", "chapter-5-beam"):
        structure = STRUCTURES[name]()
        lines = sets_of(structure, tmp_path)[3:]
        assert {line["type"] for line in lines} == {82}
        assert drawn(lines) == {frozenset(member.nodes) for member in structure.members}


def test_a_straight_beam_is_one_stroke(tmp_path: Path) -> None:
    (line,) = sets_of(steel_beam(), tmp_path)[3:]
    np.testing.assert_array_equal(line["nodes"], np.arange(1, 22))
    assert line["n_nodes"] == 21


def test_a_trace_line_has_250_nodes_at_most(tmp_path: Path) -> None:
    long_beam = steel_beam(n_elements=600)
    lines = sets_of(long_beam, tmp_path)[3:]
    assert [line["n_nodes"] for line in lines] == [len(line["nodes"]) for line in lines]
    assert max(line["n_nodes"] for line in lines) <= 250
    assert drawn(lines) == {frozenset(member.nodes) for member in long_beam.members}
    fan = tuple(Member(i, (1, i + 1), BAR, STEEL) for i in range(1, 200))
    star = Structure({i: (float(i > 1), float(i)) for i in range(1, 201)}, fan)
    assert drawn(sets_of(star, tmp_path)[3:]) == {frozenset(member.nodes) for member in fan}


def test_the_header_says_where_the_file_is_from_and_the_same_file_comes_twice(tmp_path: Path) -> None:
    made = datetime(2026, 12, 24, 18, 0, 1, tzinfo=UTC)
    origin = Origin("a1b2", "structure    -1\n  é", "0.1", made)
    header = sets_of(steel_beam(), tmp_path, origin)[0]
    assert (header["model_name"], header["description"], header["program"]) == (
        "a1b2",
        "structure -1 ?",
        "modallab 0.1",
    )
    assert (header["date_file_written"], header["time_file_written"]) == ("24-Dec-26", "18:00:01")
    assert uff_geometry.write(steel_beam(), origin) == uff_geometry.write(steel_beam(), origin)
