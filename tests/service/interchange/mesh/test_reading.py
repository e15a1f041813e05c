"""Files of meshes: what is damaged, asks for other files or is read wrong elsewhere is refused."""

from pathlib import Path

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.interchange.mesh.reading import read_mesh, starts

HERE = Path(__file__).parent
GMSH = (HERE / "gmsh_41.msh").read_bytes()
BINARY = (HERE / "gmsh_41_binary.msh").read_bytes()
INP = """*HEADING
** made by hand
*NODE
10, 0., 0., 0.
** a comment within
11, 1., 0., 0.
12, 1., 1., 0.
13, 0., 1., 0.
*ELEMENT, TYPE=S4R, ELSET=skin
5, 10, 11, 12, 13
*ELEMENT, TYPE=B31, ELSET=edge
6, 10, 11
** another
7, 11, 12
*NSET, NSET=corner
10
"""
VTK = """# vtk DataFile Version 3.0
by hand
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 4 double
0 0 0 1 0 0 1 1 0 0 1 0
CELLS 2 8
4 0 1 2 3
2 0 1
CELL_TYPES 2
9 3
CELL_DATA 2
SCALARS part int 1
LOOKUP_TABLE default
7 9
"""


def test_lists_of_abaqus_go_on_behind_comments() -> None:
    mesh = read_mesh(INP.encode())
    assert mesh.types == ["quad", "line", "line"]
    assert {name: cells.tolist() for name, cells in mesh.groups.items()} == {"skin": [0], "edge": [1, 2]}
    assert mesh.point_groups["corner"].tolist() == [0]
    assert mesh.points.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


def test_cells_without_names_are_grouped_by_the_number_that_they_carry() -> None:
    mesh = read_mesh(VTK.encode())
    assert {name: cells.tolist() for name, cells in mesh.groups.items()} == {"part 7": [0], "part 9": [1]}


def test_names_of_gmsh_are_the_groups_and_no_others() -> None:
    mesh = read_mesh(GMSH)
    sizes = {name: len(cells) for name, cells in mesh.groups.items()}
    assert sizes == {"left": 5, "rib": 5, "thin": 20, "thick half": 40}
    assert mesh.points.shape == (54, 3)
    for name in ("gmsh_41_binary", "gmsh_22"):
        other = read_mesh((HERE / f"{name}.msh").read_bytes())
        assert {group: len(cells) for group, cells in other.groups.items()} == sizes
        np.testing.assert_allclose(other.points, mesh.points, atol=1e-10 * 600)  # 16 digits


@pytest.mark.parametrize("head", [b"GRID,1", b"PK\x03\x04", b"", b"* 1", b"\x89HDF"])
def test_other_files_are_no_meshes(head: bytes) -> None:
    assert not starts(head)


WRONG = {
    "no mesh": b"words",
    "half a file of gmsh": GMSH[: len(GMSH) // 2],
    "half a binary one": BINARY[: len(BINARY) // 2],
    "another version": GMSH.replace(b"4.1 0 8", b"9.9 0 8"),
    "no header": b"$MeshFormat\n",
    "an unknown point": INP.replace("5, 10, 11", "5, 10, 99").encode(),
    "a place that is no number": INP.replace("11, 1., 0.", "11, one, 0.").encode(),
    "a place that is not finite": INP.replace("11, 1., 0.", "11, nan, 0.").encode(),
    "an unknown element": INP.replace("S4R", "S9R5").encode(),
    "another file": (INP + "*Include, input=/etc/passwd\n").encode(),
    "parts that are moved about": (INP + "*PART, NAME=a\n*PART, NAME=b\n").encode(),
    "named lists and others": INP.replace(", ELSET=skin", "").encode(),
    "a name for two lists": INP.replace("ELSET=edge", "ELSET=skin").encode(),
    "half a file of VTK": VTK[: len(VTK) // 2].encode(),
    "a point beyond": VTK.replace("2 0 1\n", "2 0 8\n").encode(),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_no_whole_mesh_is_refused(case: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        read_mesh(WRONG[case])
    assert caught.value.context["field"]


def test_no_other_file_is_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = "\n".join(line for line in INP.splitlines() if not line.startswith("**"))
    (tmp_path / "other.inp").write_text(plain)
    monkeypatch.chdir(tmp_path)
    for line in (
        "*INCLUDE,INPUT=other.inp",
        "*include , input = other.inp",
        " *INCLUDE, INPUT=other.inp",
        "INCLUDE,INPUT=other.inp",
        "**\n\x1c*INCLUDE,INPUT=other.inp",
    ):
        with pytest.raises(InvalidInputError, match="INCLUDE"):
            read_mesh(f"*HEADING\n{line}\n".encode())
