"""Datasets of a universal file: sizes are checked against the file first, then pyuff reads dataset 58."""

import tempfile
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.interchange.settings import UNIVERSAL
from modallab.interchange.uff_split import FUNCTION, refusal, split
from modallab.interchange.uff_text import program_of

UNITS, HEADER = 164, 151


def read_sets(payload: bytes, largest: int, kinds: Collection[int]) -> Iterator[dict[str, Any]]:
    """Yield header (151: `program`), units (164: `length, force`) and functions (58: as pyuff has them).

    Parameters
    ----------
    payload
        The file.
    largest
        Bytes it may have.
    kinds
        Types of the functions wanted; others pass by.

    Raises
    ------
    InvalidInputError
        If it is no universal file, is cut off, or declares more or other numbers than it holds.
    """
    import pyuff  # only files of this format need it

    counts = []
    # pyuff works on paths only
    with tempfile.TemporaryDirectory(prefix="modallab-") as folder:
        path = Path(folder) / "tidy.uff"
        with path.open("wb") as file:
            for dataset in split(
                _limited(payload, largest),
                {UNITS: UNIVERSAL.max_small_bytes, HEADER: UNIVERSAL.max_small_bytes},
                kinds,
            ):
                if dataset.text is None:
                    continue
                # Not by pyuff, which refuses harmless headers with missing lines.
                if dataset.number == HEADER:
                    yield {"type": HEADER, "program": program_of(dataset.text.decode("ascii", "replace"))}
                elif dataset.number == UNITS:
                    length, force = factors(dataset.text.decode("ascii", "replace"))
                    yield {"type": UNITS, "length": length, "force": force}
                else:
                    file.write(dataset.text)
                    counts.append(dataset.count)
        try:
            reader = pyuff.UFF(str(path))
        except Exception as error:  # pyuff raises nothing narrower
            raise refusal(f"the file cannot be read: {error}") from None
        if reader.get_n_sets() != len(counts):
            raise refusal("the marks between the datasets are not clear")
        for index, count in enumerate(counts):
            yield _parsed(reader, index, count)


def read_texts(payload: bytes, largest: int, text_limits: Mapping[int, int]) -> Iterator[tuple[int, str]]:
    """Yield the number and the lines of text datasets, without mark and number.

    Parameters
    ----------
    payload
        The file.
    largest
        Bytes it may have.
    text_limits
        The datasets' numbers, and the bytes beyond which each passes by.

    Raises
    ------
    InvalidInputError
        If it is no universal file, or is cut off.
    """
    for dataset in split(_limited(payload, largest), text_limits, ()):
        if dataset.text is not None:
            yield dataset.number, dataset.text.decode("ascii", "replace")


def factors(units: str) -> tuple[float, float]:
    """Return the divisors of lengths and forces for SI units, from the text of dataset 164.

    Raises
    ------
    InvalidInputError
        If they are missing, or of a size that no unit has.
    """
    fields = " ".join(units.upper().replace("D", "E").split("\n")[1:]).split()[:2]
    try:
        length, force = (float(field) for field in fields)
    except ValueError:
        raise refusal("the file's units (164) cannot be read", value=" ".join(fields)[:40]) from None
    if not (1e-12 < length < 1e12 and 1e-12 < force < 1e12):  # NaN fails too
        raise refusal("the file's units (164) are out of bounds", value=f"{length:g}, {force:g}")
    return length, force


def _limited(payload: bytes, largest: int) -> bytes:
    limit = min(largest, UNIVERSAL.max_bytes)
    if len(payload) > limit:
        raise refusal(
            f"the universal file is larger than {limit / 1e6:g} MB; what does not belong to FRFs, such as "
            "time records, may be left out of it",
            allowed=limit,
        )
    return payload


def _parsed(reader: Any, index: int, count: int) -> dict[str, Any]:
    try:
        with np.errstate(all="ignore"):
            dataset: dict[str, Any] = reader.read_sets(index)
    except Exception as error:  # pyuff raises nothing narrower
        raise refusal(f"dataset {index + 1} cannot be read: {error}", dataset=index + 1) from None
    if dataset["type"] != FUNCTION:
        raise refusal(f"dataset {index + 1} cannot be read", dataset=index + 1)
    x, data = np.asarray(dataset["x"]), np.asarray(dataset["data"])
    if len(x) != count or len(data) != count:
        raise refusal(
            f"dataset {index + 1} holds another number of values than it declares",
            dataset=index + 1,
            value=len(data),
            allowed=count,
        )
    _check_finite(data, x, index)
    return dataset


def _check_finite(data: NDArray[Any], x: NDArray[Any], index: int) -> None:
    bad = np.flatnonzero(~(np.isfinite(data) & np.isfinite(x)))
    if len(bad):
        raise refusal(
            f"dataset {index + 1} holds a value that is not finite, at line {bad[0] + 1} ({x[bad[0]]:g} Hz)",
            dataset=index + 1,
            line=int(bad[0]) + 1,
        )
