"""Frequency axis of a file, as lines of an analyser."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError, bounds, sentence
from modallab.interchange.settings import READING
from modallab.rig.analyser import Analyser
from modallab.rig.settings import ACQUISITION


def analyser_of(freq: FloatArray, averages: float) -> tuple[Analyser, tuple[str, ...]]:
    """Return an analyser with the lines of a file, and notes on lines that differ from the analyser's.

    Its lines are uniform from the first line of the file to the last, or from 0 Hz if the file lacks that
    line alone. The file may lack some of them. If the lines of the file are not uniform, the analyser has
    as many, and a note names the first one that is off: the FRFs keep their frequencies, and only a
    simulation refuses them.

    Parameters
    ----------
    freq
        (n_freq,) Hz, rising.
    averages
        Effective number of averages.

    Raises
    ------
    InvalidInputError
        If there are fewer or more lines than an analyser has.
    """
    if len(freq) < READING.min_lines:
        raise InvalidInputError(
            "too few lines", field="freq", value=len(freq), allowed=bounds(READING.min_lines)
        )
    candidates = [
        _with_spacing(freq, float(spacing), averages)
        for spacing in dict.fromkeys((np.median(np.diff(freq)), np.diff(freq).min()))
    ]
    for analyser in candidates:
        try:
            lines = analyser.lines_at(freq)
        except InvalidInputError:
            continue
        return analyser, _notes_on(analyser, len(lines))
    n_lines = min(len(freq), READING.max_lines)
    nearest = replace(candidates[0], frequency_min=float(freq[0]), n_lines=n_lines)
    return nearest, (_reason(nearest, freq),)


def lines_on(analyser: Analyser, freq: FloatArray, relative_error: float) -> FloatArray:
    """Return the analyser's lines that a file holds a rounded copy of, (n_freq,) Hz.

    The file may hold part of the lines.

    Parameters
    ----------
    freq
        (n_freq,) Hz, rising.
    relative_error
        Of frequencies in the file.

    Raises
    ------
    InvalidInputError
        If a line of the file is none of the analyser's, or the spacing is another.
    """
    place = (freq - analyser.frequency_min) / analyser.spacing
    lines = np.rint(place).astype(int)
    rounding = np.minimum(READING.least_rounding + relative_error * freq / analyser.spacing, 0.5)
    stray = (np.abs(place - lines) > rounding) | (lines < 0) | (lines >= analyser.n_lines)
    finest = int(np.diff(lines).min(initial=analyser.n_lines)) if len(lines) > 1 else 1
    if not stray.any() and finest == 1:
        return np.asarray(analyser.freq[lines])
    first = int(stray.argmax())
    which = f": line {first + 1}, {freq[first]:.9g} Hz, is none of these" if stray.any() else ""
    spacing = f"{float(np.median(np.diff(freq))):.9g} Hz" if len(freq) > 1 else "one line"
    raise InvalidInputError(
        f"the file's frequency axis is not the analyser's{which}",
        field="freq",
        value=f"{len(freq)} lines from {freq[0]:g} to {freq[-1]:g} Hz, {spacing} apart",
        allowed=f"lines from {analyser.frequency_min:g} to {analyser.frequency_max:g} Hz, "
        f"{analyser.spacing:.9g} Hz apart, or part of them",
    )


def _with_spacing(freq: FloatArray, spacing: float, averages: float) -> Analyser:
    """Return an analyser with about a spacing, Hz, whose lines end with the file's."""
    n_lines = round(float(freq[-1] - freq[0]) / spacing) + 1
    if n_lines > READING.max_lines:
        raise InvalidInputError(
            "too many lines, or lines too close for the range",
            field="freq",
            value=n_lines,
            allowed=bounds(READING.min_lines, READING.max_lines, unit="lines"),
        )
    analyser = Analyser(
        frequency_min=float(freq[0]),
        frequency_max=float(freq[-1]),
        n_lines=max(n_lines, READING.min_lines),
        averages=round(min(max(averages, 1.0), READING.max_averages)),
    )
    # A receptance at rest is often no number, and then not in the file.
    if round(float(freq[0]) / analyser.spacing) != 1 or n_lines >= READING.max_lines:
        return analyser
    from_rest = replace(analyser, frequency_min=0.0, n_lines=n_lines + 1)
    return from_rest if _holds(from_rest, freq) else analyser


def _holds(analyser: Analyser, freq: FloatArray) -> bool:
    try:
        analyser.lines_at(freq)
    except InvalidInputError:
        return False
    return True


def _notes_on(analyser: Analyser, n_lines: int) -> tuple[str, ...]:
    missing = analyser.n_lines - n_lines
    notes = []
    if missing > (analyser.frequency_min == 0):
        notes.append(
            f"{missing} of {analyser.n_lines} lines with a spacing of {analyser.spacing:.9g} Hz are missing"
        )
    try:
        _ = analyser.baseband
    except InvalidInputError as error:
        notes.append(f"no simulation of these lines: {sentence(error)}")
    return tuple(notes)


def _reason(analyser: Analyser, freq: FloatArray) -> str:
    place = (freq - freq[0]) / analyser.spacing
    first = int((np.abs(place - np.rint(place)) > ACQUISITION.line_tolerance).argmax())
    return (
        f"the lines are not evenly spaced, the first that is off is line {first + 1}, {freq[first]:.9g} Hz: "
        "they serve an extraction or an update, but no simulation has them"
    )
