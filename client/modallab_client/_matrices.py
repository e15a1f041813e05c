"""Matrices of a model, full or sparse, as the service takes them."""

import io
import zipfile
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab_client import _wire

Pair = tuple[Any, Any]


def npz(
    dofs: Sequence[str],
    mass: Any,
    stiffness: Any,
    groups: Mapping[str, Pair] | None,
    coordinates: Mapping[int, Sequence[float]] | None,
) -> bytes:
    """Return a model's matrices as npz, in triplets with the group of each.

    Raises
    ------
    ValueError
        If there are neither matrices nor groups, or both.
    """
    if (groups is None) == (mass is None and stiffness is None):
        raise ValueError("a model is given by mass and stiffness, or by groups of both")
    of = {"model": (mass, stiffness)} if groups is None else groups
    arrays: dict[str, Any] = {"dofs": np.array(list(dofs), str), "groups": np.array(list(of), str)}
    for i, kind in enumerate(("mass", "stiffness")):
        parts = [_triplets(pair[i]) for pair in of.values()]
        for k, name in enumerate(("rows", "columns", "values")):
            arrays[f"{kind}_{name}"] = np.concatenate([part[k] for part in parts])
        owner = [np.full(len(part[0]), g) for g, part in enumerate(parts)]
        arrays[f"{kind}_groups"] = np.concatenate(owner)
    if coordinates is not None:
        arrays["nodes"] = np.array(list(coordinates), int)
        arrays["coordinates"] = np.array([list(place) for place in coordinates.values()], float)
    return _wire.npz(**arrays)


def _triplets(matrix: Any) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return rows, columns and values of what is not zero."""
    if hasattr(matrix, "tocoo"):
        sparse = matrix.tocoo()
        return np.asarray(sparse.row), np.asarray(sparse.col), np.asarray(sparse.data, float)
    full = np.asarray(matrix, float)
    if full.ndim != 2:
        raise ValueError(f"a matrix has two dimensions, not {full.ndim}")
    rows, columns = np.nonzero(full)
    return rows, columns, full[rows, columns]


def with_table(content: bytes, dofs: Sequence[str]) -> bytes:
    """Return an archive of an OUTPUT4 file with the degrees of freedom of its rows."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("dofs.txt", "\n".join(dofs))
        archive.writestr("model.op4", content)
    return file.getvalue()
