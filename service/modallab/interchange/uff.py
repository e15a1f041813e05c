"""FRFs as universal files: dataset 58, binary out, binary and text in."""

import re
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.interchange.measured import MeasuredFile
from modallab.interchange.uff_format import (
    AUTO_SPECTRUM,
    COHERENCE,
    DENSITY,
    FORCE,
    FRF,
    MOTIONS,
    Function,
    decode,
    encode,
)
from modallab.interchange.uff_records import FUNCTION, LARGEST, UNITS, read_sets, refusal, starts
from modallab.interchange.uff_text import NOWHERE, Origin, foreign, front
from modallab.rig.measurement import Measurement

__all__ = ["LARGEST", "read", "starts", "write"]

_LABELS = {FrfKind.RECEPTANCE: "m", FrfKind.MOBILITY: "m/s", FrfKind.INERTANCE: "m/s^2"}
# Units often met, which would pass for SI without a word.
_NOT_SI = re.compile(r"(?<![A-Za-z])(g|gn|mm|um|cm|in|inch|ft|mil|ips|lb|lbf|kN|mN|dB|V|mV)(?![A-Za-z])")
_AXIS_ERROR = 1e-5  # the format has six digits for the line spacing
_ROUNDED = 1e-6  # by so much a coherence of 1 may exceed it in single precision


def write(measurement: Measurement, origin: Origin = NOWHERE) -> bytes:
    """Return FRFs, coherence and auto spectra as a universal file.

    Header (151) and SI units (164) come first. Each function is a dataset 58, binary, double
    precision. A response and the run that measured it share a version number.

    Raises
    ------
    InvalidInputError
        If the measurement has several inputs.
    """
    _only(measurement.frf.inputs)
    force, n_out = measurement.force_spectrum, len(measurement.frf.outputs)
    # Where all was measured at once there is one force.
    n_forces = 0 if force is None else 1 if (force == force[:, :1]).all() else n_out
    return front(origin) + encode([f for j in range(n_out) for f in _of_response(measurement, j, n_forces)])


def _of_response(measurement: Measurement, j: int, n_forces: int) -> Iterator[Function]:
    frf, force = measurement.frf, measurement.force_spectrum
    output, source = frf.outputs[j], frf.inputs[0]
    motion, label = MOTIONS[frf.kind], _LABELS[frf.kind]
    between = partial(Function, run=j + 1, response=output, reference=source, freq=frf.freq)
    auto = partial(Function, type=AUTO_SPECTRUM, run=j + 1, freq=frf.freq)
    yield between(type=FRF, data=frf.values[:, j, 0], numerator=motion, denominator=FORCE, units=(label, "N"))
    if measurement.coherence is not None:
        yield between(type=COHERENCE, data=measurement.coherence[:, j])
    if measurement.response_spectrum is not None:
        units, data = (f"({label})^2/Hz", "NONE"), measurement.response_spectrum[:, j]
        yield auto(response=output, reference=output, data=data, numerator=motion, units=units)
    if force is not None and j < n_forces:
        data = force[:, j, 0]
        yield auto(response=source, reference=source, data=data, numerator=FORCE, units=("N^2/Hz", "NONE"))


def read(payload: bytes, *, largest: int) -> MeasuredFile:
    """Return what a universal file holds of a measurement.

    FRFs of one kind and one reference are needed, in any order; coherence and auto spectra per Hz
    are taken where they belong to every FRF, else the notes say what was left out. Other datasets
    pass by, except units (164), by which the values are converted to SI, and the header (151),
    whose program the notes name.

    Parameters
    ----------
    payload
        The file.
    largest
        Bytes it may have.

    Raises
    ------
    InvalidInputError
        If it is no universal file, is cut off or damaged, or its FRFs make no measurement.
    """
    functions, units, program = [], (1.0, 1.0), ""
    for dataset in read_sets(payload, largest):
        if dataset["type"] == FUNCTION:
            functions.append(decode(dataset))
        elif dataset["type"] == UNITS:
            units = dataset["length"], dataset["force"]
        else:
            program = dataset["program"]
    short = [f.of for f in functions if f.of is not None and f.of != len(functions)]
    if short:
        raise refusal(
            f"the file had {short[0]} functions and has {len(functions)}: cut off, or put together of others",
            value=len(functions),
            allowed=short[0],
        )
    found = [function for function in functions if function.type == FRF]
    frf = _frf(found, units)
    reader = _Companions(functions, found, frf, units)
    return MeasuredFile(
        frf=frf,
        coherence=reader.coherence(),
        force_spectrum=reader.force_spectrum(),
        response_spectrum=reader.response_spectrum(),
        notes=(*foreign(program), *reader.notes),
        axis_error=_AXIS_ERROR,
    )


def _frf(found: Sequence[Function], units: tuple[float, float]) -> FrfSet:
    if not found:
        raise refusal("the file holds no FRF", allowed="dataset 58 with function type 4")
    kind = _kind(found, units)
    ends = [(f.response, f.reference) for f in found]
    outputs = tuple(response for response, _ in ends if response is not None)
    inputs = tuple(reference for _, reference in ends if reference is not None)
    if len(outputs) < len(found) or len(inputs) < len(found):
        raise refusal("an FRF has no response or reference direction", allowed="X, Y, Z, RX, RY, RZ")
    _only(tuple(dict.fromkeys(inputs)))
    if len({output.point for output in outputs}) < len(outputs):
        raise refusal("an FRF is in the file twice", field="outputs", value=", ".join(map(str, outputs)))
    freq = found[0].freq
    if not all(_same_axis(f.freq, freq) for f in found):
        raise refusal("the FRFs do not share one frequency axis", field="freq")
    length, force = units
    values: ComplexArray = np.stack([f.data.astype(complex) for f in found], axis=1)[:, :, None]
    values *= force / length
    return FrfSet(freq=freq, values=values, outputs=outputs, inputs=inputs[:1], kind=kind)


def _kind(found: Sequence[Function], units: tuple[float, float]) -> FrfKind:
    kinds = {(f.numerator, f.denominator) for f in found}
    motion, source = min(kinds)
    if len(kinds) > 1 or source != FORCE or motion not in MOTIONS.values():
        raise refusal(
            "the FRFs are not all displacement, velocity or acceleration per force",
            field="kind",
            value=", ".join(f"{motion} per {source}" for motion, source in sorted(kinds)),
            allowed="data types 8, 11 or 12 per 13",
        )
    strange = [label for f in found for label in f.units if _foreign(label, units)]
    if strange:
        raise refusal(
            f"the FRFs are not in SI units: {strange[0]!r}",
            field="units",
            value=strange[0],
            allowed="SI, or a dataset 164 that says the factors",
        )
    return next(kind for kind, number in MOTIONS.items() if number == motion)


def _foreign(label: str, units: tuple[float, float]) -> bool:
    return units == (1.0, 1.0) and _NOT_SI.search(label) is not None


def _only(inputs: Sequence[Dof]) -> None:
    if len(inputs) > 1:
        raise refusal(
            "FRFs of several references make several measurements: one file each",
            field="inputs",
            value=", ".join(map(str, inputs)),
            allowed="one reference",
        )


def _same_axis(freq: FloatArray, other: FloatArray) -> bool:
    return len(freq) == len(other) and np.allclose(freq, other, rtol=_AXIS_ERROR, atol=0.0)


class _Companions:
    """Picks coherence and spectra that belong to the FRFs, and notes what it leaves."""

    def __init__(
        self,
        functions: Sequence[Function],
        found: Sequence[Function],
        frf: FrfSet,
        units: tuple[float, float],
    ) -> None:
        self._functions = [f for f in functions if _same_axis(f.freq, frf.freq)]
        self._found, self._frf = found, frf
        self._units = units
        self.notes: list[str] = []

    def coherence(self) -> FloatArray | None:
        """Return the coherence of each response, (n_freq, n_out)."""
        source = self._frf.inputs[0].point
        curves = {
            f.response.point: f.data.real
            for f in self._functions
            if f.type == COHERENCE and f.response and f.reference and f.reference.point == source
        }
        values = self._stacked("coherence", curves, [dof.point for dof in self._frf.outputs])
        if values is None:
            return None
        return np.where((values > 1) & (values <= 1 + _ROUNDED), 1.0, values)

    def response_spectrum(self) -> FloatArray | None:
        """Return the auto spectrum of each response, (n_freq, n_out) unit^2/Hz."""
        motion = MOTIONS[self._frf.kind]
        curves = {f.response.point: f.data.real for f in self._densities(motion) if f.response}
        values = self._stacked("response spectra", curves, [dof.point for dof in self._frf.outputs])
        return None if values is None else values / self._units[0] ** 2

    def force_spectrum(self) -> FloatArray | None:
        """Return the force's auto spectrum in the run of each response, (n_freq, n_out, 1) N^2/Hz."""
        source = self._frf.inputs[0].point
        forces = [f for f in self._densities(FORCE) if f.response and f.response.point == source]
        runs = [f.run for f in self._found]
        curves = {f.run: f.data.real for f in forces}
        if len(forces) == 1:  # all was measured at once
            curves = dict.fromkeys(runs, forces[0].data.real)
        elif len(curves) < len(forces):
            self.notes.append("force spectra left out: which belongs to which response is not clear")
            return None
        values = self._stacked("force spectra", curves, runs)
        return None if values is None else values[:, :, None] / self._units[1] ** 2

    def _densities(self, numerator: int) -> list[Function]:
        spectra = [
            f for f in self._functions if f.type in (AUTO_SPECTRUM, DENSITY) and f.numerator == numerator
        ]
        kept = [
            f
            for f in spectra
            if (f.type == DENSITY or "/Hz" in f.units[0]) and not _foreign(f.units[0], self._units)
        ]
        if len(kept) < len(spectra):
            self.notes.append("auto spectra left out: not per Hz and in SI units")
        return kept

    def _stacked(self, name: str, curves: dict[Any, FloatArray], keys: list[Any]) -> FloatArray | None:
        if not curves:
            return None
        if not all(key in curves for key in keys):
            self.notes.append(f"{name} left out: not there for every FRF")
            return None
        return np.stack([curves[key] for key in keys], axis=1)
