"""Functions of dataset 58, decoded and encoded."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import FloatArray
from modallab.core.dof import DIRECTIONS, Dof
from modallab.core.frf import FrfKind
from modallab.interchange.points import dof_of
from modallab.interchange.settings import UNIVERSAL
from modallab.interchange.uff_text import number

AUTO_SPECTRUM, FRF, COHERENCE, DENSITY, MULTIPLE_COHERENCE = 2, 4, 6, 9, 26  # function types
KINDS = (AUTO_SPECTRUM, FRF, COHERENCE, DENSITY, MULTIPLE_COHERENCE)  # functions of a measurement
FORCE, FREQUENCY = 13, 18  # specific data types
MOTIONS = {FrfKind.RECEPTANCE: 8, FrfKind.MOBILITY: 11, FrfKind.INERTANCE: 12}
_RECORD = re.compile(r"modallab, record \d+ of (\d+)")


@dataclass(frozen=True, eq=False)
class Function:
    """A function at a response DoF, of a reference DoF."""

    type: int
    run: int
    """Version number in the file; simultaneous functions share it."""
    response: Dof | None
    reference: Dof | None
    freq: FloatArray
    data: NDArray[Any]
    numerator: int = 0
    denominator: int = 0
    units: tuple[str, str] = ("NONE", "NONE")  # of numerator and denominator, as labelled
    of: int | None = None
    """Functions of the file when it was written; None: not stated."""
    names: tuple[str, ...] = ()  # of response and reference points


def decode(dataset: dict[str, Any], names: Mapping[str, str]) -> Function:
    """Return the function that pyuff has read.

    Parameters
    ----------
    names
        DoFs of named points, which a file may have in place of node numbers.
    """
    match = _RECORD.match(dataset.get("id2", ""))
    points = tuple(str(dataset.get(f"{end}_ent_name", "")).strip() for end in ("rsp", "ref"))
    return Function(
        type=dataset["func_type"],
        run=dataset["ver_num"],
        response=_point(points[0], names, dataset["rsp_node"], dataset["rsp_dir"]),
        reference=_point(points[1], names, dataset["ref_node"], dataset["ref_dir"]),
        numerator=dataset["ordinate_spec_data_type"],
        denominator=dataset["orddenom_spec_data_type"],
        units=(dataset["ordinate_axis_units_lab"], dataset["orddenom_axis_units_lab"]),
        freq=np.asarray(dataset["x"], float),
        data=np.asarray(dataset["data"]),
        of=int(match[1]) if match else None,
        names=points,
    )


def _point(name: str, names: Mapping[str, str], node: int, direction: int) -> Dof | None:
    """Return the DoF of a point, by its name where that is known; a name may stand for the node only."""
    named = dof_of(name, names) if name in names else None
    dof = _dof(node, direction)
    if named is None or dof is None or not named[1]:
        return dof if named is None else named[0]
    return replace(dof, node=named[0].node)


def _dof(node: int, direction: int) -> Dof | None:
    if direction == 0 or abs(direction) > len(DIRECTIONS) or not 0 <= node <= UNIVERSAL.max_node:
        return None
    return Dof(node, DIRECTIONS[abs(direction) - 1], 1 if direction > 0 else -1)


def encode(functions: Sequence[Function]) -> bytes:
    """Return functions as a universal file: dataset 58b, double precision, little-endian."""
    return b"".join(_encoded(function, i + 1, len(functions)) for i, function in enumerate(functions))


def _encoded(function: Function, record: int, of: int) -> bytes:
    # Not by pyuff 2.5: it rounds the line spacing to six digits and states half the bytes of complex data.
    is_complex = np.iscomplexobj(function.data)
    data = np.ascontiguousarray(function.data, "<c16" if is_complex else "<f8").tobytes()
    freq, count = function.freq, len(function.freq)
    spacing = (freq[-1] - freq[0]) / max(count - 1, 1)
    ends = [_end(dof) for dof in (function.response, function.reference)]
    lines = [
        "    -1",
        f"{58:6d}b{1:6d}{2:6d}{11:12d}{len(data):12d}{0:6d}{0:6d}{0:12d}{0:12d}",
        f"{function.response} / {function.reference}",
        f"modallab, record {record} of {of}",
        *["NONE"] * 3,
        f"{function.type:5d}{record:10d}{function.run:5d}{0:10d} {ends[0]} {ends[1]}",
        f"{6 if is_complex else 4:10d}{count:10d}{1:10d}{number(freq[0])}{number(spacing)}{number(0.0)}",
        _axis(FREQUENCY, "Hz"),
        _axis(function.numerator, function.units[0]),
        _axis(function.denominator, function.units[1]),
        _axis(0, "NONE"),
    ]
    header = "".join(f"{line}\n" for line in lines).encode("ascii")
    return header + data + b"    -1\n"


def _end(dof: Dof | None) -> str:
    node, direction = (0, 0) if dof is None else (dof.node, dof.sign * (DIRECTIONS.index(dof.direction) + 1))
    return f"{'NONE':<10}{node:10d}{direction:4d}"


def _axis(kind: int, unit: str) -> str:
    return f"{kind:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {unit:<20}"
