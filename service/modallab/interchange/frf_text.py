"""FRFs in the text layout of the program that comes with the thesis (`.FRF`, appendix E), in and out.

docs/files.md describes the layout.
"""

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from modallab.core.dof import DIRECTIONS, Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.interchange.file_content import FileContent
from modallab.interchange.frf_block import KINDS, assemble, read_blocks
from modallab.interchange.settings import FRF_TEXT_FILE
from modallab.interchange.uff_split import refusal

if TYPE_CHECKING:
    from modallab.rig.measurement import Measurement

_FIRST = re.compile(
    rb"[^\n]*\n[ \t]*[123][ \t]*\r?\n *\d+ +[-+.\dEeDd]+ +[-+.\dEeDd]+[ \t]*\r?\n[ \t]*[01][ \t]*\r?\n"
)


def starts(head: bytes) -> bool:
    """Return whether a file begins as those of the program do: title, kind, axis, coherence flag."""
    return _FIRST.match(head) is not None


def write(measurement: "Measurement", decimals: int = FRF_TEXT_FILE.program_decimals) -> bytes:
    """Return FRFs and coherence, a block each, SI units.

    Parameters
    ----------
    measurement
        The measurement; its spectra have no place in this layout.
    decimals
        Of every number: 3 keeps to the columns of the program, 16 loses nothing.

    Raises
    ------
    InvalidInputError
        If there are too few or too many decimals.
    """
    if not FRF_TEXT_FILE.program_decimals <= decimals <= FRF_TEXT_FILE.all_decimals:
        raise InvalidInputError(
            "the decimals are out of bounds",
            field="decimals",
            value=decimals,
            allowed=bounds(FRF_TEXT_FILE.program_decimals, FRF_TEXT_FILE.all_decimals),
        )
    frf = measurement.frf
    blocks = [(j, i) for j in range(len(frf.outputs)) for i in range(len(frf.inputs))]
    lines: list[str] = []
    for number, (j, i) in enumerate(blocks, 1):
        title = f"modallab, FRF {number} of {len(blocks)}: {frf.outputs[j]} / {frf.inputs[i]}"
        lines += _block(measurement, j, i, title, decimals)
    return "".join(f"{line}\n" for line in lines).encode("ascii")


def _block(measurement: "Measurement", j: int, i: int, title: str, decimals: int) -> Iterator[str]:
    frf, coherence = measurement.frf, measurement.coherence
    freq, output, source = frf.freq, frf.outputs[j], frf.inputs[i]
    spacing = (freq[-1] - freq[0]) / max(len(freq) - 1, 1)
    wide = decimals + 7
    yield title
    yield f" {KINDS.index(frf.kind) + 1}"
    yield f"{'':7}{len(freq):5d}{_fixed(freq[0], wide, decimals)}{_fixed(spacing, wide, decimals)}"
    yield f" {int(coherence is not None)}"
    yield "".join(
        f"{integer:12d}" for integer in (source.node, _direction(source), output.node, _direction(output), 0)
    )
    yield " 0 0 0 0 0"
    yield f"{_coordinate(source):12d}{_coordinate(output):12d}"
    pairs = np.ascontiguousarray(frf.values[:, j, i]).view(float)
    values = np.where(np.abs(pairs) < FRF_TEXT_FILE.smallest_number, 0.0, pairs)
    yield from _rows("values", (f"{value:{wide}.{decimals}E}" for value in values.tolist()), "")
    if coherence is not None:
        curve = coherence[:, j] if coherence.ndim == 2 else coherence[:, j, i]
        yield from _rows("coherence", (_fixed(value, decimals + 4, decimals) for value in curve), " ")
    yield from _rows("freq", (_fixed(value, decimals + 4, decimals - 2) for value in freq), " ")


def _rows(name: str, texts: Iterator[str], margin: str) -> Iterator[str]:
    fields, size = (
        list(texts),
        FRF_TEXT_FILE.values_per_row if name == "values" else FRF_TEXT_FILE.others_per_row,
    )
    for at in range(0, len(fields), size):
        yield margin + "".join(fields[at : at + size])


def _fixed(value: float, width: int, decimals: int) -> str:
    # At least one blank: the columns of the program overflow from 100,000 Hz.
    return f" {value:.{decimals}f}".rjust(width)


def _direction(dof: Dof) -> int:
    return dof.sign * (DIRECTIONS.index(dof.direction) + 1)


def _coordinate(dof: Dof) -> int:
    """Return the coordinate number of a DoF: six for each node, from 1."""
    return len(DIRECTIONS) * (dof.node - 1) + DIRECTIONS.index(dof.direction) + 1


def read(payload: bytes, *, largest: int) -> FileContent:
    """Return the measured FRFs of a file of one or more blocks.

    Parameters
    ----------
    payload
        The file.
    largest
        Bytes it may have.

    Raises
    ------
    InvalidInputError
        If it is cut off or damaged, or its blocks make no measurement.
    """
    limit = min(largest, FRF_TEXT_FILE.max_bytes)
    if len(payload) > limit:
        raise refusal(f"the FRF text file is larger than {limit} bytes", allowed=limit)
    return assemble(list(read_blocks(payload.decode("latin-1"))))
