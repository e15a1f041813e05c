"""Meshes from files of unknown origin, read by meshio: points, cells and their groups."""

import importlib
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.interchange.settings import MODEL_FILE

# names that meshio itself gives to groups without meaning for properties
_INTERNAL = ("gmsh:bounding_entities", "gmsh:geometrical")
FORMATS = ("gmsh", "abaqus", "vtk", "medit")  # names of modules of meshio
_DIMENSION = {"vertex": 0, "line": 1, "triangle": 2, "quad": 2}


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells of one type."""

    type: str  # meshio's name
    points: IntArray  # (n, k) places among the points


@dataclass(frozen=True, eq=False)
class Mesh:
    """Points and cells, and groups of both by name; cells are counted through all blocks."""

    points: FloatArray  # (n, 3) in the mesh's unit of length
    blocks: tuple[Cells, ...]
    groups: Mapping[str, IntArray]  # cells
    point_groups: Mapping[str, IntArray]

    @property
    def types(self) -> list[str]:
        """(n_cells,) the type of every cell."""
        return [block.type for block in self.blocks for _ in range(len(block.points))]

    @property
    def corners(self) -> list[IntArray]:
        """(n_cells,) the points of every cell."""
        return [row for block in self.blocks for row in block.points]


def starts(head: bytes) -> bool:
    """Return whether a file that begins with these bytes may be a mesh."""
    return _format(head) is not None


def read_mesh(payload: bytes) -> Mesh:
    """Return the mesh that a file of gmsh, Abaqus, VTK or Medit holds.

    Raises
    ------
    InvalidInputError
        If it is no such file, is damaged, or asks for another one.
    """
    name = _format(payload[:4096])
    if name is None:
        raise InvalidInputError("the file holds no mesh", field="file", allowed=list(FORMATS))
    if name == "abaqus":
        payload = _plain_abaqus(payload)
    try:
        with TemporaryDirectory(prefix="modallab-") as folder:
            path = Path(folder) / "mesh"
            path.write_bytes(payload)
            return _checked(_read(path, name))
    except (InvalidInputError, MemoryError):
        raise
    # Any: the parsers of meshio raise a dozen kinds at hostile bytes.
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"[:300]
        raise InvalidInputError(f"not a mesh of {name}: {reason}", field="file", allowed=name) from None


def _format(head: bytes) -> str | None:
    text = head.lstrip()
    if text.startswith((b"$MeshFormat", b"$Comments")):
        return "gmsh"
    if text.startswith(b"# vtk DataFile"):
        return "vtk"
    if text.startswith(b"MeshVersionFormatted"):
        return "medit"
    return "abaqus" if re.match(rb"\*(\*|[A-Za-z])", text) else None


def _plain_abaqus(payload: bytes) -> bytes:
    """Return an Abaqus file without comments, which meshio takes for the end of a list.

    Raises
    ------
    InvalidInputError
        If it asks for another file, moves parts about, or names some lists of elements only.
    """
    text = payload.decode("ascii", "replace")
    lines = [line for line in text.splitlines() if not line.startswith("**")]
    # A line's keyword as meshio finds it, which asks for no asterisk.
    keywords = [line.partition(",")[0].replace("*", "").strip().upper() for line in lines]
    for keyword, limit in (("INCLUDE", 0), ("INSTANCE", 1), ("PART", 1)):
        if keywords.count(keyword) > limit:
            raise InvalidInputError(
                f"the file has *{keyword}" + " more than once" * limit,
                field=f"*{keyword}",
                value=keywords.count(keyword),
                allowed="one whole part, where it stands",
            )
    lists = [
        line.upper().replace(" ", "") for line, key in zip(lines, keywords, strict=True) if key == "ELEMENT"
    ]
    names = [match[1] for line in lists if (match := re.search(r"ELSET=([^,]+)", line))]
    # meshio counts named lists as if all were.
    if names and (len(names) < len(lists) or len(set(names)) < len(names)):
        raise InvalidInputError(
            "some lists of elements have an ELSET and others none, or two the same",
            field="*ELEMENT",
            value=len(lists),
            allowed="an ELSET of its own for each *ELEMENT, or none and *ELSET",
        )
    return ("\n".join(lines) + "\n").encode("ascii", "replace")


def _checked(mesh: Any) -> Mesh:
    points = np.asarray(mesh.points, float).reshape(len(mesh.points), -1)
    if not len(points) or points.shape[1] > 3 or not np.abs(points).max() <= MODEL_FILE.max_coordinate:
        raise InvalidInputError(
            "the mesh has no points, or no places for them", field="file", value=len(points)
        )
    blocks = tuple(Cells(str(block.type), np.asarray(block.data, int)) for block in mesh.cells)
    for block in blocks:
        if block.points.ndim != 2 or not ((block.points >= 0) & (block.points < len(points))).all():
            raise InvalidInputError(f"a {block.type} has no such point", field="file", value=block.type)
    sizes = [len(block.points) for block in blocks]
    return Mesh(
        np.pad(points, ((0, 0), (0, 3 - points.shape[1]))),
        blocks,
        {name: cells for name, cells in _groups(mesh, blocks, sizes) if len(cells)},
        {str(name): np.asarray(places, int) for name, places in mesh.point_sets.items()},
    )


def _groups(mesh: Any, blocks: Sequence[Cells], sizes: Sequence[int]) -> Iterator[tuple[str, IntArray]]:
    """Yield groups of cells: sets, physical names, or the numbers that cells carry."""
    first = np.cumsum([0, *sizes])
    names = set()
    for name, parts in mesh.cell_sets.items():
        if name not in _INTERNAL:
            names.add(name)
            members = [np.asarray([] if part is None else part, int) for part in parts]
            yield name, np.concatenate([start + part for start, part in zip(first, members, strict=False)])
    tags = mesh.cell_data.get("gmsh:physical", ())
    for name, (tag, dimension) in mesh.field_data.items():
        if name not in names and tags:
            names.add(name)
            is_member = [
                (np.asarray(part) == tag) & (_DIMENSION.get(block.type, 3) == dimension)
                for part, block in zip(tags, blocks, strict=True)
            ]
            yield name, np.flatnonzero(np.concatenate(is_member))
    if names:
        return
    for array, parts in mesh.cell_data.items():
        values = np.concatenate(
            [np.asarray(part).reshape(size, -1) for part, size in zip(parts, sizes, strict=True)]
        )
        if array not in _INTERNAL and values.dtype.kind in "iu" and values.shape[1] == 1:
            for value in np.unique(values):
                yield f"{array} {value}", np.flatnonzero(values[:, 0] == value)


def _read(path: Path, name: str) -> Any:
    """Return the mesh of a file of a format; each has a module of meshio, slow to import."""
    return importlib.import_module(f"meshio.{name}").read(path)
