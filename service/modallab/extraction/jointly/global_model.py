"""A modal model out of fits of all FRFs at once."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel, Mode, StabilisationChart
from modallab.correlation.complexity import phase_collinearity
from modallab.extraction.collating.collate import COMPLEX, NODE, SMALL
from modallab.extraction.collating.collated_words import no_scale
from modallab.extraction.collating.driving_point import driving_point_flags
from modallab.extraction.collating.scaling import scaled_shapes
from modallab.extraction.jointly.global_range import RangeModes, pairs
from modallab.extraction.measured.responses import Responses


@dataclass(frozen=True, eq=False)
class GlobalFit:
    """What one range of lines holds."""

    lines: slice  # of the responses
    modes: RangeModes


def modal_model(
    fits: Sequence[GlobalFit],
    responses: Responses,
    *,
    method: str,
    n_modes: int | None,
    choices: Mapping[str, str],
) -> ModalModel:
    """Return the modes of all ranges as one set.

    Parameters
    ----------
    fits
        At least one, in rising frequency.
    n_modes
        How many to keep, the most prominent ones; all if None.
    """
    chosen = _chosen(fits, n_modes)
    parts = [(fit, rows, _modes(fit.modes, rows, responses)) for fit, rows in zip(fits, chosen, strict=True)]
    constants = [
        (fit.modes.fit.modal_constant[rows], fit.modes.fit.modal_constant_error[rows])
        for fit, rows, _ in parts
    ]
    taken = sum(len(rows) for rows in chosen)
    return ModalModel(
        modes=tuple(mode for _, _, modes in parts for mode in modes),
        dofs=responses.dofs,
        drive=responses.drive,
        normalisation="none" if responses.drive_row is None else "mass",
        method=method,
        modal_constant=np.concatenate([constant for constant, _ in constants]),
        modal_constant_error=np.concatenate([error for _, error in constants]),
        chart=_chart(fits, chosen),
        choices=dict(choices),
        notes=(
            *no_scale(responses.drive_row, responses.drive),
            *_notes(fits, chosen),
            *([f"{n_modes} modes asked for, {taken} found"] if n_modes and taken < n_modes else []),
        ),
    )


def _chosen(fits: Sequence[GlobalFit], n_modes: int | None) -> list[IntArray]:
    """Return the modes kept of each range: inside it, and of these the most prominent."""
    inside = [np.flatnonzero(fit.modes.inside) for fit in fits]
    if n_modes is None or sum(len(rows) for rows in inside) <= n_modes:
        return inside
    height = [_prominence(fit.modes)[rows] for fit, rows in zip(fits, inside, strict=True)]
    least = np.sort(np.concatenate(height))[-n_modes]
    return [rows[high >= least] for rows, high in zip(inside, height, strict=True)]


def _prominence(modes: RangeModes) -> FloatArray:
    """Return peak mobility squared over the FRFs, each in parts of its strongest mode, (n_modes,)."""
    fit = modes.fit
    peak = np.abs(fit.modal_constant) / (fit.loss_factor * fit.frequency)[:, None]
    strongest = peak.max(axis=0)
    return np.asarray(((peak / np.where(strongest > 0, strongest, 1.0)) ** 2).sum(axis=1))


def _modes(modes: RangeModes, rows: IntArray, responses: Responses) -> list[Mode]:
    fit, at = modes.fit, responses.drive_row
    sense = 1 if at is None else responses.dofs[at].sign * responses.drive.sign
    constant, error = fit.modal_constant[rows], fit.modal_constant_error[rows]
    shapes, shape_errors = scaled_shapes(constant, error, at, sense)
    close = pairs(fit, [int(row) for row in rows])
    return [
        Mode(
            frequency=float(fit.frequency[row]),
            loss_factor=float(fit.loss_factor[row]),
            shape=shapes[n],
            standard_errors={
                "frequency": float(fit.frequency_error[row]),
                "loss_factor": float(fit.loss_factor_error[row]),
            },
            shape_errors=shape_errors[n],
            flags=(
                *close.get(int(row), []),
                *_leaked(modes, int(row)),
                *_nodes(constant[n], error[n], responses.dofs),
                *_odd(shapes[n], constant[n], error[n], at, sense, responses.dofs),
            ),
        )
        for n, row in enumerate(rows)
    ]


def _leaked(modes: RangeModes, row: int) -> Iterator[str]:
    """Yield by how much leakage may still bias a mode, where that is more than the random error."""
    if modes.leakage_bias is None:
        return
    fit = modes.fit
    bias = modes.leakage_bias[row]
    if bias[0] > fit.frequency_error[row] or bias[1] > fit.loss_factor_error[row]:
        share = 100 * bias[1] / fit.loss_factor[row]
        yield f"leakage_bias: up to {bias[0]:.2g} Hz in frequency and {share:.2g} % of the loss factor"


def _nodes(constant: ComplexArray, error: FloatArray, dofs: Sequence[Dof]) -> Iterator[str]:
    """Yield the FRFs that hardly show a mode."""
    size = np.abs(constant)
    hidden: BoolArray = size < np.maximum(NODE * error, SMALL * size.max())
    for j in np.flatnonzero(hidden).tolist():
        yield f"node: {dofs[j]}"


def _odd(
    shape: ComplexArray,
    constant: ComplexArray,
    error: FloatArray,
    at: int | None,
    sense: int,
    dofs: Sequence[Dof],
) -> Iterator[str]:
    """Yield what is unusual about a shape: its drive point, or its phases."""
    if at is not None:
        yield from driving_point_flags(complex(constant[at]), float(error[at]), dofs[at], sense)
    if shape.any() and (collinearity := float(phase_collinearity(shape[:, None])[0])) < COMPLEX:
        yield f"complex shape: phase collinearity {collinearity:.2f}"


def _chart(fits: Sequence[GlobalFit], chosen: Sequence[IntArray]) -> StabilisationChart:
    """Return the charts of all ranges as one, their modes counted as in the modal model."""
    charts, before = [], 0
    for fit, rows in zip(fits, chosen, strict=True):
        number = np.full(len(fit.modes.fit.eigenvalue) + 1, -1)
        number[rows] = before + np.arange(len(rows))
        chart = fit.modes.chart
        charts.append(replace(chart, mode=number[chart.mode]))  # -1 finds the -1 at the end
        before += len(rows)
    return StabilisationChart(
        *(
            np.concatenate([getattr(chart, name) for chart in charts])
            for name in ("order", "frequency", "loss_factor", "stability", "mode")
        )
    )


def _notes(fits: Sequence[GlobalFit], chosen: Sequence[IntArray]) -> Iterator[str]:
    """Yield why each mode is one, what was left out, and what noise the FRFs share."""
    number = 0
    for fit, rows in zip(fits, chosen, strict=True):
        for row in rows:
            number += 1
            yield f"mode {number}, {fit.modes.fit.frequency[row]:.5g} Hz: {fit.modes.reasons[row]}"
        for row in np.flatnonzero(~np.isin(np.arange(len(fit.modes.inside)), rows)):
            beyond = "less prominent than those asked for" if fit.modes.inside[row] else "beyond the range"
            yield f"left out, {fit.modes.fit.frequency[row]:.5g} Hz: {beyond}"
        for reason in fit.modes.notes:
            yield f"left out, {reason}"
        if fit.modes.fit.common > 0:
            share = 100 * fit.modes.fit.common
            yield f"the FRFs have {share:.0f} % of their random error in common: standard errors allow for it"
