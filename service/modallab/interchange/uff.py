"""FRFs as universal files: dataset 58, binary out, binary and text in."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import DIRECTIONS, Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.interchange.file_content import FileContent
from modallab.interchange.reading_options import NO_OPTIONS, ReadingOptions
from modallab.interchange.settings import UNIVERSAL
from modallab.interchange.uff_companions import Companions, not_si, same_axis
from modallab.interchange.uff_contents import contents, data_type
from modallab.interchange.uff_format import (
    AUTO_SPECTRUM,
    COHERENCE,
    FORCE,
    FRF,
    KINDS,
    MOTIONS,
    MULTIPLE_COHERENCE,
    Function,
    decode,
    encode,
)
from modallab.interchange.uff_records import HEADER, UNITS, read_sets
from modallab.interchange.uff_split import FUNCTION, refusal, starts
from modallab.interchange.uff_text import NOWHERE, Origin, foreign, front

if TYPE_CHECKING:
    from modallab.rig.measurement import Measurement

__all__ = ["read", "starts", "write"]

_UNTOLD = (0, 1)  # specific data types: unknown, general
_LABELS = {FrfKind.RECEPTANCE: "m", FrfKind.MOBILITY: "m/s", FrfKind.INERTANCE: "m/s^2"}


def write(measurement: "Measurement", origin: Origin = NOWHERE) -> bytes:
    """Return FRFs, coherence and auto spectra as a universal file.

    Header (151) and SI units (164) come first. Each function is a dataset 58, binary, double precision.
    Functions of one run of the analyser have the same version number.
    """
    inputs, force = measurement.frf.inputs, measurement.force_spectrum
    roved = measurement.setup.exciter.kind == "hammer" and len(inputs) > 1
    # Simultaneous responses share one force spectrum for each drive.
    one_force = force is not None and bool((force == force[:, :1]).all())
    functions: list[Function] = []
    for j in range(len(measurement.frf.outputs)):
        for i in range(len(inputs)):
            run = j * len(inputs) + i + 1 if roved else j + 1
            functions += _of_frf(measurement, j, i, run)
            if force is not None and (j == 0 or not one_force):
                functions.append(_auto(measurement, inputs[i], run, force[:, j, i], FORCE, "N"))
    return front(origin) + encode(functions)


def _of_frf(measurement: "Measurement", j: int, i: int, run: int) -> Iterator[Function]:
    """Yield an FRF with its coherence and auto spectrum; those of a response come with its first FRF."""
    frf, coherence, response = measurement.frf, measurement.coherence, measurement.response_spectrum
    output, source = frf.outputs[j], frf.inputs[i]
    motion, label = MOTIONS[frf.kind], _LABELS[frf.kind]
    between = partial(Function, run=run, response=output, reference=source, freq=frf.freq)
    yield between(type=FRF, data=frf.values[:, j, i], numerator=motion, denominator=FORCE, units=(label, "N"))
    if coherence is not None and coherence.ndim == 3:
        yield between(type=COHERENCE, data=coherence[:, j, i])
    elif coherence is not None and len(frf.inputs) == 1:
        yield between(type=COHERENCE, data=coherence[:, j])
    elif coherence is not None and i == 0:
        yield Function(MULTIPLE_COHERENCE, run, output, None, frf.freq, coherence[:, j])
    if response is not None and (i == 0 or response.ndim == 3):
        data = response[:, j] if response.ndim == 2 else response[:, j, i]
        yield _auto(measurement, output, run, data, motion, label if label == "m" else f"({label})")


def _auto(
    measurement: "Measurement", dof: Dof, run: int, data: FloatArray, kind: int, label: str
) -> Function:
    units = (f"{label}^2/Hz", "NONE")
    return Function(AUTO_SPECTRUM, run, dof, dof, measurement.frf.freq, data, numerator=kind, units=units)


def read(payload: bytes, *, largest: int, options: ReadingOptions = NO_OPTIONS) -> FileContent:
    """Return the measured FRFs of a universal file.

    FRFs of one kind are needed, in any order, one of each response and reference; coherence and auto spectra
    per Hz are read if every FRF has them, else the notes name what was omitted. Of other datasets only two
    are used: units (164), by which the values are converted to SI, and the header (151), whose program the
    notes name.

    Parameters
    ----------
    payload
        The file.
    largest
        Bytes it may have.
    options
        A `unit`, which overrides the units that the file declares, and the DoFs of named points.

    Raises
    ------
    InvalidInputError
        If it is no universal file, is cut off or damaged, or its FRFs make no measurement.
    """
    functions, units, program = [], (1.0, 1.0), ""
    for dataset in read_sets(payload, largest, KINDS):
        if dataset["type"] == FUNCTION:
            functions.append(decode(dataset, options.map))
        elif dataset["type"] == UNITS and not options.unit:
            units = dataset["length"], dataset["force"]
        elif dataset["type"] == HEADER:
            program = dataset["program"]
    short = [f.of for f in functions if f.of is not None and f.of != len(functions)]
    if short:
        raise refusal(
            f"the file had {short[0]} functions and has {len(functions)}: cut off, or put together of others",
            value=len(functions),
            allowed=short[0],
        )
    frf_functions = [function for function in functions if function.type == FRF]
    if not frf_functions:
        raise refusal(
            f"the file holds no FRF; what it holds: {contents(payload)}",
            allowed="dataset 58 with function type 4",
        )
    frf = _frf(frf_functions, units, options)
    reader = Companions(functions, frf_functions, frf, None if options.unit else units)
    return FileContent(
        frf=frf,
        coherence=reader.coherence(),
        force_spectrum=reader.force_spectrum(),
        response_spectrum=reader.response_spectrum(),
        notes=(*foreign(program), *reader.notes),
        axis_error=UNIVERSAL.axis_error,
    )


def _frf(functions: Sequence[Function], units: tuple[float, float], options: ReadingOptions) -> FrfSet:
    kind = _kind(functions, units, options)
    ends = [(f.response, f.reference) for f in functions]
    outputs = tuple(dict.fromkeys(response for response, _ in ends if response is not None))
    inputs = tuple(dict.fromkeys(reference for _, reference in ends if reference is not None))
    if any(response is None or reference is None for response, reference in ends):
        raise refusal(
            "an FRF has no response or reference direction: `map` may tell DoFs of named points",
            value=next((name for f in functions for name in f.names if name), ""),
            allowed=list(DIRECTIONS),
        )
    _check_complete(ends, outputs, inputs)
    freq = functions[0].freq
    if not all(same_axis(f.freq, freq) for f in functions):
        raise refusal("the FRFs do not share one frequency axis", field="freq")
    length, force = units
    curves = {(f.response, f.reference): f.data for f in functions}
    values: ComplexArray = np.empty((len(freq), len(outputs), len(inputs)), complex)
    for j, output in enumerate(outputs):
        for i, source in enumerate(inputs):
            values[:, j, i] = curves[output, source]
    values *= force / length
    return FrfSet(freq=freq, values=values, outputs=outputs, inputs=inputs, kind=kind)


def _check_complete(
    ends: Sequence[tuple[Dof | None, Dof | None]], outputs: Sequence[Dof], inputs: Sequence[Dof]
) -> None:
    """Raise unless every pair of response and reference has exactly one FRF."""
    points = [{dof.point for dof in dofs} for dofs in (outputs, inputs)]
    if len(set(ends)) < len(ends) or [len(outputs), len(inputs)] != [len(point_set) for point_set in points]:
        raise refusal("an FRF is in the file twice", field="outputs", value=list(map(str, outputs)))
    if len(ends) < len(outputs) * len(inputs):
        raise refusal(
            "not every response has an FRF of every reference",
            field="inputs",
            value=list(map(str, inputs)),
            allowed="all of them, or a file for each reference",
        )


def _kind(functions: Sequence[Function], units: tuple[float, float], options: ReadingOptions) -> FrfKind:
    kinds = {(f.numerator, f.denominator) for f in functions}
    stated = options.kind if options.frf_unit is None else options.frf_unit.kind
    if stated is not None and all(quantity in _UNTOLD for pair in kinds for quantity in pair):
        return stated
    motion, source = min(kinds)
    if len(kinds) > 1 or source != FORCE or motion not in MOTIONS.values():
        quantities = ", ".join(
            f"{data_type(motion)} per {data_type(source)}" for motion, source in sorted(kinds)
        )
        label = " ".join(dict.fromkeys(f.units[0] for f in functions))
        raise refusal(
            "the FRFs must all be displacement, all velocity or all acceleration, per force; by their data "
            f"types they are {quantities}, by their labels {label!r}",
            field="kind",
            value=[f"{motion} per {source}" for motion, source in sorted(kinds)],
            allowed="data types 8, 11 or 12 per 13",
        )
    strange = [label for f in functions for label in f.units if not_si(label, units)]
    if strange and not options.unit:
        raise refusal(
            f"the FRFs are not in SI units: {strange[0]!r}",
            field="units",
            value=strange[0],
            allowed="SI, a dataset 164 that says the factors, or `unit`",
        )
    return next(kind for kind, number in MOTIONS.items() if number == motion)
