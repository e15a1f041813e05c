"""Models from an archive of Matrix Market files: mass, stiffness, degrees of freedom."""

import io
import zipfile
from typing import Any

import numpy as np
from scipy.io import mminfo, mmread
from scipy.sparse import coo_array, csc_array

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.damping import Damping
from modallab.fe.imported import MOST, GroupMatrices, of_groups
from modallab.fe.structure import Structure

TABLE = "dofs.txt"
ENDING = ".mtx"
MASS, STIFFNESS = f"mass{ENDING}", f"stiffness{ENDING}"
_ALLOWED = f"{MASS}, {STIFFNESS}, {TABLE}; or a folder of the first two for each group"
WHOLE = "model"


def read(payload: bytes, *, largest: int, damping: Damping | None = None, name: str = "") -> Structure:
    """Return the structure whose matrices a zip archive holds.

    Parameters
    ----------
    payload
        The archive: `dofs.txt`, a degree of freedom a line as `5:+Z`, `mass.mtx` and `stiffness.mtx`; of a
        model in groups, a folder of each group's name that holds both.
    largest
        Bytes that its files may take when unpacked.

    Raises
    ------
    InvalidInputError
        If it is no such archive, is damaged, or its matrices are those of no structure.
    """
    files = _unpacked(payload, largest)
    if TABLE not in files:
        raise InvalidInputError(f"the archive lacks {TABLE}", field="file", allowed=_ALLOWED)
    dofs = _table(files[TABLE])
    parts: dict[str, dict[str, csc_array]] = {}
    for path, content in files.items():
        folder, _, last = path.rpartition("/")
        if last in (MASS, STIFFNESS):
            parts.setdefault(folder or WHOLE, {})[last] = _matrix(content, path, len(dofs))
    none = csc_array((len(dofs), len(dofs)))
    for last in (MASS, STIFFNESS):
        if not any(last in part for part in parts.values()):
            raise InvalidInputError(f"the archive lacks {last}", field="file", allowed=_ALLOWED)
    groups = [
        GroupMatrices(group, part.get(MASS, none), part.get(STIFFNESS, none))
        for group, part in sorted(parts.items())
    ]
    return of_groups(groups, dofs, damping=damping, name=name)


def _unpacked(payload: bytes, largest: int) -> dict[str, bytes]:
    try:
        with zipfile.ZipFile(io.BytesIO(payload)) as archive:
            infos = [info for info in archive.infolist() if not info.is_dir()]
            total = sum(info.file_size for info in infos)
            if total > largest:
                raise InvalidInputError(
                    "the matrices are too large", field="file", value=total, allowed=largest
                )
            wanted = [info for info in infos if info.filename.endswith((ENDING, TABLE))]
            return {info.filename: archive.read(info) for info in wanted}
    except InvalidInputError:
        raise
    # Any: decompressors raise a dozen kinds at hostile bytes.
    except Exception as error:
        raise InvalidInputError(f"not a zip archive: {error}", field="file", allowed=_ALLOWED) from None


def _table(content: bytes) -> tuple[Dof, ...]:
    try:
        lines = content.decode("utf-8").split()
    except UnicodeDecodeError:
        raise InvalidInputError(f"{TABLE} is no text", field=TABLE, allowed="a line as 5:+Z each") from None
    return tuple(Dof.parse(line, field=TABLE) for line in lines)


def _matrix(content: bytes, path: str, n: int) -> csc_array:
    try:
        # A header may claim any size, and all of it would be made room for.
        rows, columns, _, form, *_ = mminfo(io.BytesIO(content))
        fits = (rows, columns) == (n, n) and (form != "array" or n**2 <= MOST)
        found: Any = mmread(io.BytesIO(content), spmatrix=False) if fits else np.zeros((0, 0))
    # Any: its parser raises ValueError, OverflowError and others at hostile bytes.
    except Exception as error:
        raise InvalidInputError(
            f"{path} is no Matrix Market file: {error}", field=path, allowed="Matrix Market"
        ) from None
    matrix = coo_array(found)
    if matrix.shape != (n, n) or matrix.dtype.kind not in "iuf" or not np.isfinite(matrix.data).all():
        raise InvalidInputError(
            f"{path} does not fit {TABLE}",
            field=path,
            value=f"{rows} x {columns}, {form} of {matrix.dtype}",
            allowed=f"finite real numbers, ({n}, {n})",
        )
    return csc_array(matrix.astype(float))
