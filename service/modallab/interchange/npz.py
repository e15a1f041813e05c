"""Measurements from npz files of unknown origin: every array is checked."""

from typing import Any

from numpy.typing import NDArray

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.interchange.measured import MeasuredFile
from modallab.interchange.npz_arrays import dofs, load, numbers, reals, texts

_REQUIRED = ("freq", "values", "outputs", "inputs", "kind")
_OPTIONAL = ("coherence", "averages", "force_spectrum", "response_spectrum")


def read(payload: bytes, *, largest: int) -> MeasuredFile:
    """Return the measured FRFs of a npz file.

    Parameters
    ----------
    payload
        The file: `freq, values, outputs, inputs, kind`, and optionally `coherence, averages,
        force_spectrum, response_spectrum`.
    largest
        Bytes that the arrays may take when unpacked.

    Raises
    ------
    InvalidInputError
        If it is no such file, its arrays do not fit together, or hold NaN.
    """
    arrays = load(payload, (*_REQUIRED, *_OPTIONAL), largest)
    missing = [name for name in _REQUIRED if name not in arrays]
    if missing:
        raise InvalidInputError(f"the file lacks {', '.join(missing)}", field="file", allowed=list(_REQUIRED))
    frf = FrfSet(
        freq=reals(arrays, "freq", 1),
        values=numbers(arrays, "values", 3),
        outputs=dofs(arrays, "outputs"),
        inputs=dofs(arrays, "inputs"),
        kind=_kind(arrays["kind"]),
    )

    def optional(name: str, *ranks: int) -> FloatArray | None:
        return reals(arrays, name, *ranks) if name in arrays else None

    return MeasuredFile(
        frf=frf,
        coherence=optional("coherence", 2, 3),
        averages=float(reals(arrays, "averages", 0)) if "averages" in arrays else None,
        force_spectrum=optional("force_spectrum", 3),
        response_spectrum=optional("response_spectrum", 2, 3),
    )


def _kind(array: NDArray[Any]) -> FrfKind:
    text = ", ".join(texts(array, "kind"))
    if text not in tuple(FrfKind):
        raise InvalidInputError(f"no kind {text!r}", field="kind", value=text, allowed=list(FrfKind))
    return FrfKind(text)
