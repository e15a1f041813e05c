"""FRFs with coherence and spectra as a file holds them, without a rig."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.assumption import Assumption
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind, FrfSet
from modallab.interchange.settings import READING

ZERO_COHERENCE = "coherence is 0 everywhere, and taken as unknown"
_ARRAYS = ("coherence", "force_spectrum", "response_spectrum")
_CROSS_SPECTRA = "force_cross_spectra"  # of a single file: forces in different files did not act at once


@dataclass(frozen=True)
class Piece:
    """One file of a test."""

    name: str
    """Name of the file, which may tell its points."""
    content: bytes
    number: int = 1
    """Place among the files of the test, from 1."""


@dataclass(frozen=True, eq=False)
class FileContent:
    """FRFs with coherence and spectra from a file, without a rig."""

    frf: FrfSet
    coherence: FloatArray | None = None
    """(n_freq, n_out), or of each FRF (n_freq, n_out, n_in)."""
    averages: float | None = None
    """Effective number of averages."""
    force_spectrum: FloatArray | None = None
    """N^2/Hz, (n_freq, n_out, n_in), auto spectrum of the force."""
    response_spectrum: FloatArray | None = None
    """unit^2/Hz, shaped as `coherence`, auto spectra of the responses."""
    force_cross_spectra: ComplexArray | None = None
    """N^2/Hz, (n_freq, n_out, n_in, n_in), cross spectra of simultaneous forces."""
    notes: tuple[str, ...] = ()
    axis_error: float = READING.axis_error  # relative error that the format leaves in the frequencies
    assumed: tuple[Assumption, ...] = ()

    def __post_init__(self) -> None:
        arrays = {
            "values": self.frf.values,
            "force_spectrum": self.force_spectrum,
            "response_spectrum": self.response_spectrum,
            "force_cross_spectra": self.force_cross_spectra,
        }
        for name, array in arrays.items():
            largest = 0.0 if array is None else float(np.abs(array).max(initial=0.0))
            if largest > READING.max_magnitude:
                raise InvalidInputError(
                    f"{name} holds a number of no size that can be computed with",
                    field=name,
                    value=largest,
                    allowed=bounds(maximum=READING.max_magnitude),
                )

    @property
    def simultaneous(self) -> bool:
        """Whether several forces acted at once: FRFs of a response have one coherence, or one spectrum."""
        arrays = (self.coherence, self.response_spectrum)
        return len(self.frf.inputs) > 1 and any(array is not None and array.ndim == 2 for array in arrays)

    def with_tidy_coherence(self) -> "FileContent":
        """Return the content with coherence rounded down to 1, and without a coherence of zeros only."""
        coherence = self.coherence
        if coherence is None:
            return self
        if not coherence.any():
            return replace(self, coherence=None, notes=(*self.notes, ZERO_COHERENCE))
        rounded = (coherence > 1) & (coherence <= 1 + READING.coherence_rounding)
        return replace(self, coherence=np.where(rounded, 1.0, coherence)) if rounded.any() else self

    def scaled(self, response: float, force: float, kind: FrfKind | None) -> "FileContent":
        """Return the content in SI units.

        Parameters
        ----------
        response, force
            SI units of the number 1 in the file.
        kind
            Kind of the FRFs that follows from their unit; None if none follows.

        Raises
        ------
        InvalidInputError
            If the file has FRFs of another kind.
        """
        if kind not in (None, self.frf.kind):
            raise InvalidInputError(
                f"the unit is one of {kind}, and the file holds {self.frf.kind}", field="unit", value=kind
            )
        if (response, force) == (1.0, 1.0):
            return self
        spectra: tuple[tuple[Any, float], ...] = (
            (self.force_spectrum, force),
            (self.response_spectrum, response),
            (self.force_cross_spectra, force),
        )
        force_spectrum, response_spectrum, cross_spectra = (
            None if array is None else array * factor**2 for array, factor in spectra
        )
        return replace(
            self,
            frf=replace(self.frf, values=self.frf.values * (response / force)),
            force_spectrum=force_spectrum,
            response_spectrum=response_spectrum,
            force_cross_spectra=cross_spectra,
        )

    def as_arrays(self) -> dict[str, Any]:
        """Return arrays and lists of names by name, for another process."""
        names = (*_ARRAYS, _CROSS_SPECTRA)
        present = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        return present | {"freq": self.frf.freq, "values": self.frf.values}

    def as_json(self) -> dict[str, Any]:
        """Return everything but the arrays as JSON, for another process."""
        return {
            "outputs": [str(dof) for dof in self.frf.outputs],
            "inputs": [str(dof) for dof in self.frf.inputs],
            "kind": self.frf.kind.value,
            "averages": self.averages,
            "notes": list(self.notes),
            "axis_error": self.axis_error,
            "assumed": [[a.quantity, a.value, a.reason] for a in self.assumed],
        }


def fields_from(tree: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """Return the fields of a `FileContent` from the results of its `as_json` and `as_arrays`."""
    outputs, inputs = (tuple(map(Dof.parse, tree[name])) for name in ("outputs", "inputs"))
    return {
        "frf": FrfSet(arrays["freq"], arrays["values"], outputs, inputs, FrfKind(tree["kind"])),
        **{name: arrays.get(name) for name in (*_ARRAYS, _CROSS_SPECTRA)},
        "averages": tree["averages"],
        "notes": tuple(tree["notes"]),
        "axis_error": tree["axis_error"],
        "assumed": tuple(Assumption(*texts) for texts in tree["assumed"]),
    }


def same_axis(freq: FloatArray, reference: FloatArray, error: float) -> bool:
    """Return whether two axes differ by no more than `error`, relative to the last frequency."""
    return len(freq) == len(reference) and np.allclose(
        freq, reference, rtol=error, atol=error * float(reference[-1]) / max(len(reference), 1)
    )


def merged(contents: Sequence[FileContent]) -> FileContent:
    """Return the content of several files of one test as one.

    Raises
    ------
    InvalidInputError
        If kinds or axes differ, an FRF is there twice, or a pair of response and force has none.
    """
    first = contents[0]
    if len(contents) == 1:
        return first
    if any(content.frf.kind is not first.frf.kind for content in contents):
        raise InvalidInputError("the files hold FRFs of several kinds", field="kind", allowed="one kind")
    error = max(content.axis_error for content in contents)
    if not all(same_axis(content.frf.freq, first.frf.freq, error) for content in contents):
        raise InvalidInputError("the files do not share one frequency axis", field="freq")
    outputs = tuple(dict.fromkeys(dof for content in contents for dof in content.frf.outputs))
    inputs = tuple(dict.fromkeys(dof for content in contents for dof in content.frf.inputs))
    _check_complete(contents, outputs, inputs)
    values = np.empty((len(first.frf.freq), len(outputs), len(inputs)), complex)
    for content in contents:
        values[_places(content, outputs, inputs)] = content.frf.values
    frf = FrfSet(first.frf.freq, values, outputs, inputs, first.frf.kind)
    joined: dict[str, Any] = {name: _joined(name, contents, outputs, inputs) for name in _ARRAYS}
    lacking = [
        f"{name} left out: not there for every FRF"
        for name, array in joined.items()
        if array is None and any(getattr(content, name) is not None for content in contents)
    ]
    averages = {content.averages for content in contents}
    return FileContent(
        frf=frf,
        **joined,
        averages=averages.pop() if len(averages) == 1 else None,
        notes=(*dict.fromkeys(note for content in contents for note in content.notes), *lacking),
        axis_error=error,
        assumed=tuple(dict.fromkeys(a for content in contents for a in content.assumed)),
    )


def _places(content: FileContent, outputs: Sequence[Dof], inputs: Sequence[Dof]) -> Any:
    rows = [outputs.index(dof) for dof in content.frf.outputs]
    columns = [inputs.index(dof) for dof in content.frf.inputs]
    return np.ix_(range(len(content.frf.freq)), rows, columns)


def _check_complete(contents: Sequence[FileContent], outputs: Sequence[Dof], inputs: Sequence[Dof]) -> None:
    """Raise unless every pair of response and force has exactly one FRF."""
    pairs = [(j, i) for content in contents for j in content.frf.outputs for i in content.frf.inputs]
    if len(set(pairs)) < len(pairs):
        twice = next(pair for pair in pairs if pairs.count(pair) > 1)
        raise InvalidInputError(
            f"the FRF {twice[0]} / {twice[1]} is in the files twice", field="outputs", value=str(twice[0])
        )
    missing = sorted({(j, i) for j in outputs for i in inputs}.difference(pairs))
    if missing:
        listed = ", ".join(f"{j} / {i}" for j, i in missing[: READING.max_listed])
        raise InvalidInputError(
            f"not every response has an FRF of every force: {len(missing)} are missing, such as {listed}",
            field="inputs",
            value=list(map(str, inputs)),
            allowed="all of them, or a test for each force",
        )


def _joined(
    name: str, contents: Sequence[FileContent], outputs: Sequence[Dof], inputs: Sequence[Dof]
) -> FloatArray | None:
    arrays = [getattr(content, name) for content in contents]
    if any(array is None for array in arrays):
        return None
    combined: FloatArray = np.empty((len(contents[0].frf.freq), len(outputs), len(inputs)))
    for content, array in zip(contents, arrays, strict=True):
        combined[_places(content, outputs, inputs)] = array.reshape(*array.shape[:2], -1)
    return combined[:, :, 0] if len(inputs) == 1 and name != "force_spectrum" else combined
