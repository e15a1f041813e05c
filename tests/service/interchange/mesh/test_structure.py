"""Meshes as structures: the modes of what was described by hand, in every format and wherever they lie."""

from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError, StructureError
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.members import Material, Plate, Section
from modallab.fe.plate import Edge, Holding, plate
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import lowest_modes
from modallab.interchange.mesh.description import HeldGroup, MeshBar, MeshDescription, MeshPlate
from modallab.interchange.mesh.reading import Cells, Mesh, read_mesh
from modallab.interchange.mesh.structure import structure_of_mesh
from modallab.interchange.nastran import model as nastran

HERE = Path(__file__).parent
STEEL = Material(2.09e11, 7800.0)
SKIN = MeshPlate(STEEL, 0.004)
RIB = MeshBar(STEEL, Section(2e-4, 6.7e-9), second_moment_across=1.7e-9, torsion=4e-9)
ACROSS = ("Z", "RX", "RY")
FLAT = plate(length=0.6, width=0.4, thickness=0.004, n_elements=(6, 4), material=STEEL)
BAY = STRUCTURES["bay"]()
# A turn about no axis of the structure's: columns are orthonormal.
TURN = np.linalg.qr(np.array([[1.0, 2.0, 0.5], [-0.3, 1.0, 2.0], [1.0, 0.2, 3.0]]))[0]


def frequencies(structure: Structure, count: int = 8) -> tuple[FloatArray, int]:
    basis, n_rigid_body = lowest_modes(assemble(structure), count)
    return basis.frequencies, n_rigid_body


def gmsh(name: str = "gmsh_41") -> Mesh:
    return read_mesh((HERE / f"{name}.msh").read_bytes())


def halves(**more: object) -> MeshDescription:
    """Return what the plate of gmsh is made of, its rib and its named side left out."""
    made = {"thin": SKIN, "thick half": SKIN}
    return replace(MeshDescription(made, left_out=("rib", "left"), length_unit=1e-3), **more)  # type: ignore[arg-type]


def of(structure: Structure, kind: str) -> Mesh:
    """Return a described structure's members as a mesh of one group, as its points are numbered."""
    place = {node: i for i, node in enumerate(structure.nodes)}
    cells = np.array([[place[node] for node in member.nodes] for member in structure.all_members])
    points = np.pad(np.array(list(structure.nodes.values())), ((0, 0), (0, 1)))
    return Mesh(points, (Cells(kind, cells),), {"all": np.arange(len(cells))}, {})


def written(path: Path, form: str) -> bytes:
    """Return the flat plate as a file of meshio, in two groups."""
    mesh = of(FLAT, "quad")
    tags = np.where(np.arange(24) < 10, 1, 2)
    data = {"gmsh:physical": [tags], "gmsh:geometrical": [tags]} if form == "gmsh22" else {"kind": [tags]}
    names = {"one": np.array([1, 2]), "two": np.array([2, 2])} if form == "gmsh22" else {}
    sets = {} if form == "gmsh22" else {"one": [np.arange(10)], "two": [np.arange(10, 24)]}
    blocks = [(block.type, block.points) for block in mesh.blocks]
    given = meshio.Mesh(
        mesh.points,
        blocks,
        cell_data={} if form == "abaqus" else data,
        field_data=names,
        cell_sets=sets if form == "abaqus" else {},
        point_sets={"left": np.arange(0, 35, 7)} if form == "abaqus" else {},
    )
    more = {"binary": False} if form in ("gmsh22", "vtk") else {}
    meshio.write(path, given, file_format="vtk" if form.startswith("vtk") else form, **more)
    return path.read_bytes()


NAMES = {"gmsh22": ("one", "two"), "abaqus": ("one", "two"), "vtk": ("kind 1", "kind 2")}


@pytest.mark.parametrize("form", ["gmsh22", "abaqus", "vtk", "vtk binary", "medit"])
def test_a_plate_of_every_format_has_the_modes_of_the_one_described(form: str, tmp_path: Path) -> None:
    mesh = read_mesh(written(tmp_path / "mesh", form))
    names = NAMES.get(form.split(" ")[0], tuple(mesh.groups))
    given = structure_of_mesh(mesh, MeshDescription(dict.fromkeys(names, SKIN)))
    assert given.groups == {names[0]: tuple(range(1, 11)), names[1]: tuple(range(11, 25))}
    assert given.dofs == FLAT.dofs
    own, n_rigid_body = frequencies(FLAT)
    found, rigid = frequencies(given)
    assert rigid == n_rigid_body
    np.testing.assert_allclose(found, own, rtol=1e-8)  # all digits were written


def test_files_of_gmsh_say_the_same_in_every_version() -> None:
    held = halves(supports=(HeldGroup("left", ACROSS),))
    own, n_rigid_body = frequencies(structure_of_mesh(gmsh(), held))
    assert n_rigid_body == 0
    for name in ("gmsh_41_binary", "gmsh_22"):
        other = structure_of_mesh(gmsh(name), held)
        assert {group: len(of) for group, of in other.groups.items()} == {"thin": 20, "thick half": 40}
        # elements in another order: rounding, times the highest eigenvalue over the lowest, 1e9
        np.testing.assert_allclose(frequencies(other)[0], own, rtol=1e-6)


def test_a_clamped_plate_of_gmsh_is_near_a_fine_one() -> None:
    fine = plate(
        length=0.6,
        width=0.4,
        thickness=0.004,
        n_elements=(24, 16),
        material=STEEL,
        edges={Edge.LEFT: Holding.CLAMPED},
    )
    found, _ = frequencies(structure_of_mesh(gmsh(), halves(supports=(HeldGroup("left", ACROSS),))), 4)
    # eight by five elements of two kinds: 6 % at 4 across, of mode 4 32 %, as docs/models.md has them
    np.testing.assert_allclose(found, frequencies(fine, 4)[0], rtol=0.1)


def test_a_plate_has_its_modes_wherever_it_lies_in_space() -> None:
    mesh = gmsh()
    own, _ = frequencies(structure_of_mesh(mesh, halves()))
    turned = structure_of_mesh(replace(mesh, points=mesh.points @ TURN.T), halves())
    assert len(turned.dofs) == 6 * 54
    found, n_rigid_body = frequencies(turned)
    assert n_rigid_body == 6
    # the lowest move across the plate: rounding, times the stiffness in its plane over that across it
    np.testing.assert_allclose(found, own, rtol=1e-6)


def test_a_frame_has_its_modes_in_its_plane_and_in_space() -> None:
    mesh, (first, *_) = of(BAY, "line"), BAY.members
    bars = MeshBar(first.material, first.section)
    alike = BAY.of_members(replace(m, section=first.section, material=first.material) for m in BAY.members)
    given = structure_of_mesh(mesh, MeshDescription({"all": bars}))
    assert given.dofs == BAY.dofs
    own, _ = frequencies(alike)
    np.testing.assert_allclose(frequencies(given)[0], own, rtol=1e-8)
    in_plane = TURN @ np.array([0.9, 0.5, 0.0])  # along no bar
    turned = replace(bars, upright=tuple(in_plane.tolist()))
    space = structure_of_mesh(replace(mesh, points=mesh.points @ TURN.T), MeshDescription({"all": turned}))
    found, n_rigid_body = frequencies(space, 60)
    assert n_rigid_body == 6
    # the plane of a frame is one of symmetry: rounding of a matrix twice as large
    assert np.abs(found[:, None] / own - 1).min(axis=0).max() < 1e-8


def test_a_rib_on_a_plate_is_that_of_bulk_data() -> None:
    mesh = gmsh()
    given = structure_of_mesh(
        mesh, halves(groups={"thin": SKIN, "thick half": SKIN, "rib": RIB}, left_out=("left",))
    )
    assert {name: len(of) for name, of in given.groups.items()} == {"rib": 5, "thin": 20, "thick half": 40}
    cards = [f"GRID,{i + 1},,{x / 1e3:.12f},{y / 1e3:.12f},0." for i, (x, y, _) in enumerate(mesh.points)]
    cards += ["MAT1,1,2.09+11,,.3,7800.", "PSHELL,1,1,.004,1,,1", "PBAR,2,1,2.-4,6.7-9,1.7-9,4.-9"]
    for member in given.all_members:
        rim = ",".join(map(str, member.nodes))
        kind = {2: "CBAR,{},2,{},0.,0.,1.", 3: "CTRIA3,{},1,{}", 4: "CQUAD4,{},1,{}"}[len(member.nodes)]
        cards.append(kind.format(member.number, rim))
    other = nastran.read("\n".join(cards).encode())
    own, n_rigid_body = frequencies(other)
    found, rigid = frequencies(given)
    assert rigid == n_rigid_body == 6
    np.testing.assert_allclose(found, own, rtol=1e-8)


def test_a_group_has_a_thickness_that_an_update_may_move() -> None:
    given = structure_of_mesh(gmsh(), halves(groups={"thin": SKIN, "thick half": MeshPlate(STEEL, 0.008)}))
    sizes = {member.group: member.thickness for member in given.non_bar_members if isinstance(member, Plate)}
    assert sizes == {"thin": 0.004, "thick half": 0.008}


def test_a_point_group_holds_its_points(tmp_path: Path) -> None:
    mesh = read_mesh(written(tmp_path / "mesh", "abaqus"))
    held = MeshDescription({"one": SKIN, "two": SKIN}, supports=(HeldGroup("left", ACROSS),))
    clamped = plate(
        length=0.6,
        width=0.4,
        thickness=0.004,
        n_elements=(6, 4),
        material=STEEL,
        edges={Edge.LEFT: Holding.CLAMPED},
    )
    assert structure_of_mesh(mesh, held).dofs == clamped.dofs


SOLID = Mesh(
    np.vstack([np.eye(3), np.zeros(3)]),
    (Cells("tetra", np.array([[0, 1, 2, 3]])), Cells("triangle", np.array([[0, 1, 2]]))),
    {"body": np.array([0]), "skin": np.array([1])},
    {},
)
LINE = Mesh(np.zeros((2, 3)), (Cells("line", np.array([[0, 1]])),), {"a": np.array([0])}, {})
UP = Mesh(np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 1.0]]), LINE.blocks, LINE.groups, {})
WARPED = Mesh(
    np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.1], [0.0, 1.0, 0.0]]),
    (Cells("quad", np.array([[0, 1, 2, 3]])),),
    {"a": np.array([0])},
    {},
)
FOLDED = replace(WARPED, blocks=(Cells("quad", np.array([[0, 2, 1, 3]])),))
BAR = MeshBar(STEEL, Section(1e-4, 1e-9))
WRONG = {
    "solids": (SOLID, MeshDescription({"skin": SKIN}), r"tetra \(1\), in body \(1\)"),
    "solids that are described": (SOLID, MeshDescription({"body": SKIN}), r"group body: tetra \(1\)"),
    "lines as plates": (gmsh(), halves(groups={"rib": SKIN}), r"group rib: line \(5\)"),
    "cells without a description": (
        gmsh(),
        MeshDescription({"thin": SKIN}, left_out=("line",)),
        r"triangle \(40\), in thick half",
    ),
    "cells with two": (
        replace(gmsh(), groups={**gmsh().groups, "again": gmsh().groups["thin"]}),
        halves(groups={"thin": SKIN, "again": SKIN, "thick half": SKIN}),
        "group again and another",
    ),
    "an unknown group": (gmsh(), halves(groups={"thim": SKIN}), "no group 'thim'"),
    "an unknown side": (gmsh(), halves(supports=(HeldGroup("right", ACROSS),)), "no group 'right'"),
    "nothing described": (gmsh(), None, "says nothing of sections"),
    "a bar without length": (LINE, MeshDescription({"a": BAR}), "no length"),
    "a bar along what turns it": (
        UP,
        MeshDescription({"a": replace(BAR, upright=(0.0, 2.0, 2.0))}),
        "along the vector",
    ),
    "a warped plate": (WARPED, MeshDescription({"a": SKIN}), "warped"),
    "a folded plate": (FOLDED, MeshDescription({"a": SKIN}), "folded"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_makes_no_structure_is_refused_by_name(case: str) -> None:
    mesh, described, message = WRONG[case]
    with pytest.raises((InvalidInputError, StructureError), match=message):
        structure_of_mesh(mesh, described)


def test_the_groups_that_there_are_come_back_with_the_error() -> None:
    with pytest.raises(InvalidInputError) as caught:
        structure_of_mesh(gmsh(), None)
    assert caught.value.context["allowed"] == ["left (5)", "rib (5)", "thin (20)", "thick half (40)"]
