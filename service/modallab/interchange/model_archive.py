"""Models from an archive of files of matrices: mass, stiffness, degrees of freedom."""

import io
import zipfile
from pathlib import PurePosixPath

from scipy.sparse import csc_array

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.damping import Damping
from modallab.fe.imported_elements import GroupMatrices, of_groups
from modallab.fe.structure import Structure
from modallab.interchange import model_matrix_market
from modallab.interchange.nastran.op4 import read_op4

TABLE = "dofs.txt"
MARKET, OP4 = ".mtx", ".op4"
ENDINGS = (MARKET, OP4)
KINDS = ("mass", "stiffness")
WHOLE = "model"
_CONTENT = (
    f"{TABLE} and mass{MARKET}, stiffness{MARKET}, the same or one file {OP4}; or a folder of each group"
)


def read(payload: bytes, *, largest: int, damping: Damping | None = None, name: str = "") -> Structure:
    """Return the structure of the matrices in a zip archive.

    Parameters
    ----------
    payload
        The archive: `dofs.txt`, a degree of freedom a line as `5:+Z`, with `mass.mtx` and `stiffness.mtx`,
        or `mass.op4` and `stiffness.op4`, or one OUTPUT4 file of both, by names that begin with M and K; of
        a model in groups, a folder of each group's name that holds these.
    largest
        Bytes that its files may take when unpacked.

    Raises
    ------
    InvalidInputError
        If it is no such archive, is damaged, or its matrices are those of no structure.
    """
    files = _unpacked(payload, largest)
    if TABLE not in files:
        raise InvalidInputError(f"the archive lacks {TABLE}", field="file", allowed=_CONTENT)
    dofs = _table(files[TABLE])
    parts: dict[str, dict[str, csc_array]] = {}
    for path, content in files.items():
        if path.endswith(ENDINGS):
            folder = parts.setdefault(path.rpartition("/")[0] or WHOLE, {})
            for kind, matrix in _matrices(content, path, len(dofs)).items():
                if kind in folder:
                    raise InvalidInputError(
                        f"{path} holds the {kind} again", field=path, value=kind, allowed="each matrix once"
                    )
                folder[kind] = matrix
    empty = csc_array((len(dofs), len(dofs)))
    for kind in KINDS:
        if not any(kind in part for part in parts.values()):
            raise InvalidInputError(f"the archive lacks the {kind}", field="file", allowed=_CONTENT)
    groups = [
        GroupMatrices(group, part.get("mass", empty), part.get("stiffness", empty))
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
            members = [info for info in infos if info.filename.endswith((*ENDINGS, TABLE))]
            return {info.filename: archive.read(info) for info in members}
    except InvalidInputError:
        raise
    # Any: decompressors raise a dozen kinds at hostile bytes.
    except Exception as error:
        raise InvalidInputError(f"not a zip archive: {error}", field="file", allowed=_CONTENT) from None


def _table(content: bytes) -> tuple[Dof, ...]:
    try:
        lines = content.decode("utf-8").split()
    except UnicodeDecodeError:
        raise InvalidInputError(f"{TABLE} is no text", field=TABLE, allowed="a line as 5:+Z each") from None
    return tuple(Dof.parse(line, field=TABLE) for line in lines)


def _matrices(content: bytes, path: str, n: int) -> dict[str, csc_array]:
    """Return the mass and stiffness matrices of a file, by the name of the file or of the matrices."""
    stem = PurePosixPath(path).stem
    if path.endswith(MARKET):
        # other matrices are ignored
        return {stem: model_matrix_market.matrix(content, path, n)} if stem in KINDS else {}
    matrices = read_op4(content, size=n, path=path)
    if stem in KINDS and len(matrices) == 1:
        return {stem: next(iter(matrices.values()))}
    kinds: dict[str, csc_array] = {}
    for name, matrix in matrices.items():
        kind = {"M": "mass", "K": "stiffness"}.get(name[:1])
        if kind is None or kind in kinds:
            raise InvalidInputError(
                f"{path}: it is open what matrix {name} is",
                field=path,
                value=name,
                allowed="one name that begins with M, and one with K",
            )
        kinds[kind] = matrix
    return kinds
