"""Modal model from fits of all FRFs."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.modal_model import DoubtfulMode, ModalModel, Mode, StabilisationChart
from modallab.extraction.averaging.leakage_flag import leakage_flags
from modallab.extraction.averaging.notes import no_scale
from modallab.extraction.averaging.reference_shapes import ReferenceShapes, reference_shapes
from modallab.extraction.averaging.settings import NODES
from modallab.extraction.multi_mode.coincident_modes import with_reciprocal_shapes
from modallab.extraction.multi_mode.range_modes import RangeModes, pair_flags
from modallab.extraction.preprocessing.responses import Responses

PRODUCT_FIT = "modal constants were fitted as products of one shape and its participation factors"


@dataclass(frozen=True, eq=False)
class GlobalFit:
    """Modes of one range of lines."""

    lines: slice
    """Index range of the lines of the responses."""
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
        Number of modes to keep, the most prominent ones; all if None.
    """
    fits = [_with_reciprocal_shapes(fit, responses) for fit in fits]
    chosen = _selected_rows(fits, n_modes)
    mode_rows = [(fit.modes, row) for fit, rows in zip(fits, chosen, strict=True) for row in rows.tolist()]
    constant = np.stack([modes.fit.modal_constant[row] for modes, row in mode_rows])
    error = np.stack([modes.fit.modal_constant_error[row] for modes, row in mode_rows])
    product = fits[0].modes.fit.participation is not None
    # constants that are fitted as products say of a DoF no more together than each of them does
    n_products = len(responses.references) if product else 1
    shapes = reference_shapes(constant, np.sqrt(n_products) * error, responses.dofs, responses.references)
    pairs = _pair_flags(fits, chosen)
    nodes = [[*_nodes(a, e, responses.frfs)] for a, e in zip(constant, error, strict=True)]
    return ModalModel(
        modes=tuple(_mode(*mode_rows[n], shapes, n, (*pairs[n], *nodes[n])) for n in range(len(mode_rows))),
        dofs=responses.dofs,
        references=responses.references,
        normalisation="none" if shapes.scale is None else "mass",
        method=method,
        modal_constant=constant,
        modal_constant_error=error,
        chart=_chart(fits, chosen),
        doubtful=_doubtful(fits, chosen),
        choices={**choices, **shapes.choice_text(PRODUCT_FIT if product else None)},
        notes=(
            *no_scale(shapes),
            *_notes(fits, chosen),
            *_missing_modes(n_modes, len(mode_rows)),
        ),
    )


def _selected_rows(fits: Sequence[GlobalFit], n_modes: int | None) -> list[IntArray]:
    """Return the modes of each range that belong to the model: all those inside it, or the most prominent."""
    inside = [np.flatnonzero(fit.modes.inside) for fit in fits]
    if n_modes is None or sum(len(rows) for rows in inside) <= n_modes:
        return inside
    height = [_prominence(fit.modes)[rows] for fit, rows in zip(fits, inside, strict=True)]
    least = np.sort(np.concatenate(height))[-n_modes]
    return [rows[high >= least] for rows, high in zip(inside, height, strict=True)]


def _prominence(modes: RangeModes) -> FloatArray:
    """Return the squared peak mobility summed over FRFs, relative to the strongest mode, (n_modes,)."""
    fit = modes.fit
    peak = np.abs(fit.modal_constant) / (fit.loss_factor * fit.frequency)[:, None]
    strongest = peak.max(axis=0)
    return np.asarray(((peak / np.where(strongest > 0, strongest, 1.0)) ** 2).sum(axis=1))


def _with_reciprocal_shapes(fit: GlobalFit, responses: Responses) -> GlobalFit:
    reciprocal = with_reciprocal_shapes(fit.modes.fit, responses.driving, responses.senses)
    return replace(fit, modes=replace(fit.modes, fit=reciprocal))


def _mode(modes: RangeModes, row: int, shapes: ReferenceShapes, n: int, flags: Sequence[str]) -> Mode:
    """Return mode `n` of the model, that of a row of its range's fit; `flags` are of more than itself."""
    fit, loss_factor = modes.fit, float(modes.fit.loss_factor[row])
    errors = _numbers(np.array([fit.frequency_error[row], fit.loss_factor_error[row]]))
    bias = {} if modes.leakage_bias is None else _numbers(modes.leakage_bias[row])
    return Mode(
        frequency=float(fit.frequency[row]),
        loss_factor=loss_factor,
        shape=shapes.shape[n],
        standard_errors=errors,
        shape_errors=shapes.error[n],
        leakage_bias=bias,
        flags=(*flags, *leakage_flags(bias, errors, loss_factor), *shapes.flags(n)),
    )


def _numbers(values: FloatArray) -> dict[str, float]:
    return dict(zip(("frequency", "loss_factor"), values.tolist(), strict=True))


def _nodes(constant: ComplexArray, error: FloatArray, names: Sequence[str]) -> Iterator[str]:
    """Yield a flag for every FRF with a small contribution of the mode."""
    size = np.abs(constant)
    hidden: BoolArray = size < np.maximum(NODES.standard_errors * error, NODES.relative_size * size.max())
    for j in np.flatnonzero(hidden).tolist():
        yield f"node: {names[j]}"


def _pair_flags(fits: Sequence[GlobalFit], chosen: Sequence[IntArray]) -> list[list[str]]:
    """Return the flags of each mode of the model that overlaps with others."""
    flags: list[list[str]] = []
    for fit, rows in zip(fits, chosen, strict=True):
        flags_by_row = pair_flags(fit.modes.fit, rows.tolist())
        flags += [flags_by_row.get(row, []) for row in rows.tolist()]
    return flags


def _missing_modes(n_requested: int | None, n_found: int) -> Iterator[str]:
    """Yield a note where fewer modes were found than requested."""
    if n_requested and n_found < n_requested:
        yield f"{n_requested} modes requested, {n_found} found"


def _chart(fits: Sequence[GlobalFit], chosen: Sequence[IntArray]) -> StabilisationChart:
    """Return the charts of all ranges as one, with modes numbered as in the modal model."""
    charts, n_modes = [], 0
    for fit, rows in zip(fits, chosen, strict=True):
        number = np.full(len(fit.modes.fit.eigenvalue) + 1, -1)
        number[rows] = n_modes + np.arange(len(rows))
        chart = fit.modes.chart
        charts.append(replace(chart, mode=number[chart.mode]))  # -1 finds the -1 at the end
        n_modes += len(rows)
    return StabilisationChart(
        *(
            np.concatenate([getattr(chart, name) for chart in charts])
            for name in ("order", "frequency", "loss_factor", "stability", "mode")
        )
    )


def _notes(fits: Sequence[GlobalFit], chosen: Sequence[IntArray]) -> Iterator[str]:
    """Yield the reason of each mode, rejected poles, and the noise common to the FRFs."""
    number = 0
    for fit, rows in zip(fits, chosen, strict=True):
        for row in rows:
            number += 1
            yield f"mode {number}, {fit.modes.fit.frequency[row]:.5g} Hz: {fit.modes.reasons[row]}"
        for row in np.flatnonzero(~np.isin(np.arange(len(fit.modes.inside)), rows)).tolist():
            yield f"left out, {fit.modes.fit.frequency[row]:.5g} Hz: {_exclusion_reason(fit.modes, row)}"
        for pole in fit.modes.left_out:
            yield f"left out, {pole.frequency:.5g} Hz: {pole.reason}"
        yield from fit.modes.drifts
        if fit.modes.fit.common_noise > 0:
            share = 100 * fit.modes.fit.common_noise
            yield f"{share:.0f} % of the random error is common to all FRFs, as the standard errors consider"


def _doubtful(fits: Sequence[GlobalFit], chosen: Sequence[IntArray]) -> tuple[DoubtfulMode, ...]:
    """Return the poles inside the ranges that are not modes of the model, in ascending frequency."""
    poles = [pole for fit in fits for pole in fit.modes.left_out]
    for fit, rows in zip(fits, chosen, strict=True):
        left = np.flatnonzero(
            (fit.modes.inside | fit.modes.bends) & ~np.isin(np.arange(len(fit.modes.inside)), rows)
        )
        poles += [
            DoubtfulMode(
                float(fit.modes.fit.frequency[row]),
                float(fit.modes.fit.loss_factor[row]),
                _exclusion_reason(fit.modes, row),
            )
            for row in left.tolist()
        ]
    return tuple(sorted(poles, key=lambda pole: pole.frequency))


def _exclusion_reason(modes: RangeModes, row: int) -> str:
    """Return the reason why a pole of the fit is not a mode."""
    if modes.inside[row]:
        return "less prominent than the requested number of modes"
    if modes.bends[row]:
        return modes.doubts[row]
    return "outside the frequency range"
