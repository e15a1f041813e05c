"""Modal model of the modes that are left after some were dropped or merged."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import FloatArray
from modallab.core.frequency_inconsistency import FrequencyInconsistency
from modallab.core.modal_model import DoubtfulMode, ModalModel, Mode, StabilisationChart
from modallab.core.numerics import SAFE_DIVISOR
from modallab.extraction.requested.constant_shapes import with_shapes_of_constants
from modallab.extraction.requested.merged_mode import NEIGHBOUR_KINDS, merged_mode
from modallab.extraction.requested.selection import ModeSelection
from modallab.extraction.summary import flag_kind

DROPPED = "dropped by request"
SELECTION, BY_REQUEST = "selection", ": by request"
_NUMBERED = re.compile(r"mode (\d+)\b(?=,| shifts)")


def select_modes(model: ModalModel, selection: ModeSelection) -> ModalModel:
    """Return the model without dropped modes, and with one mode in place of those that are merged.

    Modal constants of merged modes are added, because each fit is freed of the other modes: several poles
    that imitate one mode share its constant. A fit of constants at the common pole would see FRFs whose
    frequencies differ out of resonance: with 5 g of roving mass it leaves 1 - MAC ten times larger. Without
    constants, shapes are averaged. Poles of dropped modes are doubtful. Residuals and misfit stay.

    Parameters
    ----------
    model
        Modes in ascending frequency.
    selection
        What is dropped and merged.

    Raises
    ------
    InvalidInputError
        If the model lacks a mode, or no mode is left.
    """
    groups = selection.groups(len(model.modes))
    modes = [_mode(model, group) for group in groups]
    order = sorted(range(len(groups)), key=lambda row: modes[row].frequency)
    groups = [groups[row] for row in order]
    gone = [model.modes[n - 1].frequency for n in (*selection.drop, *(n for g in selection.merge for n in g))]
    number = {old: new for new, group in enumerate(groups) for old in group}
    selected = replace(
        model,
        modes=tuple(_without_neighbours(modes[row], gone) for row in order),
        fitted_frequency=_rows(model.fitted_frequency, groups, _mean),
        fitted_loss_factor=_rows(model.fitted_loss_factor, groups, _mean),
        modal_constant=_rows(model.modal_constant, groups, lambda rows: rows.sum(axis=0)),
        modal_constant_error=_rows(
            model.modal_constant_error, groups, lambda rows: np.linalg.norm(rows, axis=0)
        ),
        fitted_lines=_rows(model.fitted_lines, groups, _widest),
        frequency_inconsistency=_inconsistency(model, groups),
        chart=None if model.chart is None else _chart(model.chart, number),
        doubtful=_doubtful(model, selection),
        choices={**model.choices, SELECTION: _selections(model, selection)},
        notes=tuple(_renumbered(model.notes, number)),
    )
    merged = [row for row, group in enumerate(groups) if len(group) > 1]
    return selected if model.modal_constant is None else with_shapes_of_constants(selected, merged)


def _selections(model: ModalModel, selection: ModeSelection) -> str:
    """Return all selections in words, each with the numbers that modes had before it."""
    earlier = model.choices.get(SELECTION)
    words = (
        selection.words if earlier is None else f"{earlier.removesuffix(BY_REQUEST)}, then {selection.words}"
    )
    return words + BY_REQUEST


def _mode(model: ModalModel, group: Sequence[int]) -> Mode:
    modes = [model.modes[row] for row in group]
    return modes[0] if len(modes) == 1 else merged_mode(modes)


def _rows(
    array: NDArray[Any] | None,
    groups: Sequence[tuple[int, ...]],
    combined: Callable[[NDArray[Any]], NDArray[Any]],
) -> Any:
    """Return the rows of the new modes; None where there are none."""
    if array is None:
        return None
    return np.stack(
        [array[group[0]] if len(group) == 1 else combined(array[list(group)]) for group in groups]
    )


def _mean(rows: FloatArray) -> FloatArray:
    """Return the mean of the values that are known; NaN where none is."""
    known = np.isfinite(rows)
    total = np.where(known, rows, 0.0).sum(axis=0)
    return np.where(known.any(axis=0), total / np.maximum(known.sum(axis=0), 1), np.nan)


def _widest(lines: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.stack([lines[..., 0].min(axis=0), lines[..., 1].max(axis=0)], axis=-1)


def _inconsistency(model: ModalModel, groups: Sequence[tuple[int, ...]]) -> FrequencyInconsistency | None:
    """Return the frequency differences of the new modes, those of merged modes computed from their fits."""
    old = model.frequency_inconsistency
    if old is None or not any(len(group) > 1 for group in groups):
        return old if old is None else _picked(old, [group[0] for group in groups])
    still = _rows(old.still_frequency, groups, lambda rows: rows.mean(axis=0))
    fits = _rows(model.fitted_frequency, groups, _mean)
    error = _rows(old.shift_error, groups, _mean)
    mean = np.array([np.nanmean(row) if np.isfinite(row).any() else np.nan for row in fits])
    new = _picked(old, [group[0] for group in groups])
    merged = np.array([len(group) > 1 for group in groups])
    shift = np.where(merged[:, None], fits - mean[:, None], new.shift)
    squares = (shift / np.maximum(error, SAFE_DIVISOR)) ** 2
    valid = np.isfinite(squares)
    return replace(
        new,
        shift=shift,
        shift_error=error,
        chi_square=np.where(merged, np.where(valid, squares, 0.0).sum(axis=1), new.chi_square),
        degrees=np.where(merged, np.maximum(valid.sum(axis=1) - 1, 0), new.degrees),
        still_frequency=still,
    )


def _picked(old: FrequencyInconsistency, rows: list[int]) -> FrequencyInconsistency:
    names = (
        "shift",
        "shift_error",
        "chi_square",
        "degrees",
        "mode_size",
        "mode_size_error",
        "still_frequency",
    )
    return replace(old, **{name: getattr(old, name)[rows] for name in names})


def _chart(chart: StabilisationChart, number: dict[int, int]) -> StabilisationChart:
    mode = np.array([number.get(old, -1) for old in chart.mode.tolist()], np.int64)
    return replace(chart, mode=mode)


def _doubtful(model: ModalModel, selection: ModeSelection) -> tuple[DoubtfulMode, ...]:
    dropped = [model.modes[n - 1] for n in selection.drop]
    poles = [DoubtfulMode(mode.frequency, mode.loss_factor, DROPPED) for mode in dropped]
    return tuple(sorted((*model.doubtful, *poles), key=lambda pole: pole.frequency))


def _without_neighbours(mode: Mode, gone: Sequence[float]) -> Mode:
    """Return a mode without flags that name a neighbour which is no mode any more."""
    names = [f"{frequency:.5g} Hz" for frequency in gone]
    remaining_flags = [
        flag
        for flag in mode.flags
        if flag_kind(flag) not in NEIGHBOUR_KINDS or not any(name in flag for name in names)
    ]
    return replace(mode, flags=tuple(remaining_flags))


def _renumbered(notes: Sequence[str], number: dict[int, int]) -> Iterator[str]:
    """Yield the notes with new numbers of modes, without those on dropped modes."""
    for note in notes:
        match = _NUMBERED.match(note)
        if match is None:
            yield note
        elif (row := number.get(int(match[1]) - 1)) is not None:
            yield f"mode {row + 1}{note[match.end() :]}"
