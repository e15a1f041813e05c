"""Models from npz files of unknown origin: matrices element by element, or whole, by named groups."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.fe.damping import Damping
from modallab.fe.imported_elements import Element, GroupMatrices, Places, of_elements, of_groups
from modallab.fe.structure import Structure
from modallab.interchange import npz_arrays
from modallab.interchange.npz_arrays import reals, texts
from modallab.interchange.settings import MODEL_FILE

_KINDS = ("mass", "stiffness")
_TRIPLETS = ("rows", "columns", "values")
_OPTIONAL = ("element_bending", "element_numbers", "element_groups", "groups", "nodes", "coordinates")
NAMES = (
    "dofs",
    "element_dofs",
    *_OPTIONAL,
    *_KINDS,
    *(f"element_{kind}" for kind in _KINDS),
    *(f"{kind}_{part}" for kind in _KINDS for part in (*_TRIPLETS, "groups")),
)
WHOLE = "model"  # group of matrices without groups

_Arrays = Mapping[str, NDArray[Any]]


def holds_model(names: frozenset[str]) -> bool:
    """Return whether a npz file of arrays with these names is a model."""
    return "dofs" in names and bool(names & {"stiffness", "stiffness_values", "element_stiffness"})


def read(payload: bytes, *, largest: int, damping: Damping | None = None, name: str = "") -> Structure:
    """Return the structure of the matrices in a npz file.

    Parameters
    ----------
    payload
        The file. `dofs` (n,) as `5:+Z`, and either `element_dofs` (e, w), places among them, -1 behind those
        of a smaller element, with `element_mass` and `element_stiffness` (e, w, w), or `mass` and
        `stiffness`, (n, n) or as `mass_rows`, `mass_columns`, `mass_values`. Optional: `element_bending`, a
        part of the stiffness that has a coefficient of its own; `element_numbers` and `element_groups`
        (e,); `groups`, names, and `mass_groups`, `stiffness_groups`, the place of each triplet's among
        them; `nodes` (k,) and `coordinates` (k, 3), m.
    largest
        Bytes that the arrays may take when unpacked.

    Raises
    ------
    InvalidInputError
        If it is no such file, its arrays do not fit together, or are those of no structure.
    """
    arrays = npz_arrays.load(payload, NAMES, largest)
    if "dofs" not in arrays:
        raise InvalidInputError("the file lacks dofs", field="file", allowed="dofs, and mass and stiffness")
    dofs = npz_arrays.dofs(dict(arrays), "dofs")
    places = _places(arrays, dofs)
    if "element_stiffness" in arrays:
        elements = _elements(arrays, len(dofs))
        _check_sum(arrays, elements, len(dofs))
        return of_elements(elements, dofs, places, damping=damping, name=name)
    return of_groups(_groups(arrays, len(dofs)), dofs, places, damping=damping, name=name)


def _needed(arrays: _Arrays, *names: str) -> None:
    missing = [name for name in names if name not in arrays]
    if missing:
        raise InvalidInputError(f"the file lacks {', '.join(missing)}", field="file", allowed=list(names))


def _wholes(arrays: _Arrays, name: str, rank: int, lowest: int, highest: int) -> IntArray:
    """Return an array of whole numbers between bounds."""
    values = reals(dict(arrays), name, rank)
    wrong = (values != np.round(values)) | (values < lowest) | (values > highest)
    if wrong.any():
        raise InvalidInputError(
            f"{name} holds a number that is not whole, or out of bounds",
            field=name,
            value=float(values[wrong][0]),
            allowed=bounds(lowest, highest),
        )
    return values.astype(int)


def _shaped(arrays: _Arrays, name: str, shape: tuple[int, ...]) -> FloatArray:
    values = reals(dict(arrays), name, len(shape))
    if values.shape != shape:
        raise InvalidInputError(
            f"{name} has the wrong shape", field=name, value=list(values.shape), allowed=list(shape)
        )
    return values


def _places(arrays: _Arrays, dofs: tuple[Dof, ...]) -> Places | None:
    if "coordinates" not in arrays:
        return None
    _needed(arrays, "nodes", "coordinates")
    nodes = _wholes(arrays, "nodes", 1, 1, 999_999_999)
    coordinates = reals(dict(arrays), "coordinates", 2)
    if len(coordinates) != len(nodes) or coordinates.shape[1] not in (2, 3):
        raise InvalidInputError(
            "coordinates do not fit nodes",
            field="coordinates",
            value=list(coordinates.shape),
            allowed=[len(nodes), 3],
        )
    places = {
        int(node): (float(x), float(y), float(z))
        for node, (x, y, z) in zip(
            nodes, np.pad(coordinates, ((0, 0), (0, 3 - coordinates.shape[1]))), strict=True
        )
    }
    for dof in dofs:
        if dof.node not in places:
            raise InvalidInputError(
                f"node {dof.node} has no place",
                field="nodes",
                value=dof.node,
                allowed="the nodes of all dofs",
            )
    return places


def _elements(arrays: _Arrays, n: int) -> list[Element]:
    _needed(arrays, "element_dofs", "element_mass", "element_stiffness")
    rows = _wholes(arrays, "element_dofs", 2, -1, n - 1)
    n_elements, width = rows.shape
    blocks = {
        part: _shaped(arrays, f"element_{part}", (n_elements, width, width))
        for part in ("mass", "stiffness", "bending")
        if f"element_{part}" in arrays
    }
    bending = blocks.get("bending", np.zeros_like(blocks["stiffness"]))
    numbers: list[int] = list(range(1, n_elements + 1))
    if "element_numbers" in arrays:
        numbers = _wholes(arrays, "element_numbers", 1, 1, 2**31).tolist()
    groups = [WHOLE] * n_elements
    if "element_groups" in arrays:
        groups = texts(arrays["element_groups"], "element_groups")
    for name, column in (("element_numbers", numbers), ("element_groups", groups)):
        if len(column) != n_elements:
            raise InvalidInputError(
                f"{name} has the wrong length", field=name, value=len(column), allowed=n_elements
            )
    out = []
    for e in range(n_elements):
        used = np.flatnonzero(rows[e] >= 0)
        if len(set(rows[e][used].tolist())) < max(len(used), 1):
            raise InvalidInputError(
                f"element {numbers[e]} has no degree of freedom, or one twice",
                field="element_dofs",
                value=rows[e].tolist()[:24],
                allowed="each once",
            )
        at = np.ix_(used, used)
        stiffness, bent = blocks["stiffness"][e][at], bending[e][at]
        mass = blocks["mass"][e][at]
        out.append(Element(numbers[e], groups[e], rows[e][used].tolist(), mass, stiffness - bent, bent))
    return out


def _check_sum(arrays: _Arrays, elements: list[Element], n: int) -> None:
    """Raise if the file has whole matrices too, and they differ from the sum of the elements."""
    for kind in _KINDS:
        if kind not in arrays and f"{kind}_values" not in arrays:
            continue
        matrix = sum(_matrices(arrays, kind, n, 1), csc_array((n, n)))
        parts = [e.mass if kind == "mass" else e.axial + _or_none(e) for e in elements]
        r = np.concatenate([np.repeat(e.rows, len(e.rows)) for e in elements])
        c = np.concatenate([np.tile(e.rows, len(e.rows)) for e in elements])
        added = csc_array((np.concatenate([part.ravel() for part in parts]), (r, c)), shape=(n, n))
        off = float(abs(matrix - added).max()) / max(float(abs(matrix).max()), 1e-300)
        if off > MODEL_FILE.sum_tolerance:
            raise InvalidInputError(
                f"the elements do not add up to the {kind}",
                field=kind,
                value=off,
                allowed=bounds(maximum=MODEL_FILE.sum_tolerance, unit="of the largest entry"),
            )


def _or_none(element: Element) -> FloatArray:
    return np.zeros_like(element.axial) if element.bending is None else element.bending


def _groups(arrays: _Arrays, n: int) -> list[GroupMatrices]:
    names = texts(arrays["groups"], "groups") if "groups" in arrays else [WHOLE]
    if len(set(names)) < len(names) or not all(names):
        raise InvalidInputError("two groups share a name, or one has none", field="groups", value=names[:10])
    mass, stiffness = (_matrices(arrays, kind, n, len(names)) for kind in _KINDS)
    return [GroupMatrices(*group) for group in zip(names, mass, stiffness, strict=True)]


def _matrices(arrays: _Arrays, kind: str, n: int, n_groups: int) -> list[csc_array]:
    """Return a matrix of each group, (n, n)."""
    if kind in arrays:
        full = csc_array(_shaped(arrays, kind, (n, n)))
        return [full, *(csc_array((n, n)) for _ in range(n_groups - 1))]
    names = [f"{kind}_{part}" for part in _TRIPLETS]
    _needed(arrays, *names)
    rows, columns = (_wholes(arrays, name, 1, 0, n - 1) for name in names[:2])
    values = reals(dict(arrays), names[2], 1)
    owner = np.zeros(len(values), int)
    if n_groups > 1 and f"{kind}_groups" in arrays:
        owner = _wholes(arrays, f"{kind}_groups", 1, 0, n_groups - 1)
    if not len(rows) == len(columns) == len(values) == len(owner):
        raise InvalidInputError(
            f"the triplets of the {kind} are not of one length",
            field=names[2],
            value=[len(rows), len(columns), len(values), len(owner)],
            allowed="as many rows and columns as values",
        )
    masks = [owner == g for g in range(n_groups)]
    return [csc_array((values[mask], (rows[mask], columns[mask])), shape=(n, n)) for mask in masks]
