"""Modes of one frequency range: poles of all FRFs, selection of modes, and their fit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.errors import NoModeInBandError
from modallab.core.modal_model import DoubtfulMode, StabilisationChart
from modallab.core.numerics import SAFE_DIVISOR
from modallab.core.progress import Progress, part
from modallab.extraction.multi_mode.chart_settings import RANGES, SELECTION
from modallab.extraction.multi_mode.coincident_modes import coincidence_flags
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.global_method import GlobalMethod, Poles
from modallab.extraction.multi_mode.leakage_correction import LeakageCorrection, all_starts, corrected_lines
from modallab.extraction.multi_mode.leaked_modes import with_leakage_errors
from modallab.extraction.multi_mode.mode_selection import Selection, chart_of, select
from modallab.extraction.multi_mode.refinement import (
    BandData,
    RefinedModes,
    StartingPoles,
    between_ends,
    refine,
)
from modallab.extraction.multi_mode.residual_search import refine_with_search
from modallab.extraction.multi_mode.stabilisation import stabilise
from modallab.extraction.multi_mode.uniform_grid import poles_of_lines
from modallab.extraction.multi_mode.variable_projection import stack_references
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.bands import find_bands, mode_indicator

NOT_SHOWN = "residual pole without a column of the chart or a peak"
FROM_RESIDUAL = "no column of the chart: found in the residual of the fit of all other modes"


@dataclass(frozen=True, eq=False)
class RangeModes:
    """Modes of a frequency range."""

    fit: ModalFit
    """Fit of all poles."""
    weight: FloatArray
    """(n_lines, n_frf) final weights of the fit."""
    chart: StabilisationChart
    """Stabilisation chart of the range."""
    reasons: tuple[str, ...]
    """(n_modes,) reason of each mode as text."""
    inside: BoolArray
    """(n_modes,) whether a pole is a mode; poles outside the range are residual terms."""
    bends: BoolArray
    """(n_modes,) whether a pole lies inside the range but is a residual term, not a mode."""
    doubts: tuple[str, ...]
    """(n_modes,) reason why a pole inside the range is no mode, as text; empty for modes."""
    left_out: tuple[DoubtfulMode, ...]
    """Poles that the fit does not contain, with the reason."""
    drifts: tuple[str, ...] = ()
    """Drift of each mode that moves during the test, as text."""
    leakage_bias: FloatArray | None = None
    """(n_modes, 2) approximate remaining bias of frequency, Hz, and loss factor by leakage; None without
    leakage."""


def modes_of(
    find: GlobalMethod,
    band_data: BandData,
    orders: IntArray,
    damping: Damping,
    *,
    leaked: LeakageCorrection | None,
    progress: Progress,
) -> RangeModes | None:
    """Return the modes of a frequency range; None if there is none.

    Parameters
    ----------
    find
        A member of `GLOBAL_METHODS`.
    orders
        (n_orders,) orders of the chart, ascending.
    damping
        Damping model of the modes.
    leaked
        Leakage correction with its reference modes; None without leakage.
    """
    progress(0.0, "looking for poles")
    clean = band_data if leaked is None else corrected_lines(band_data, leaked, damping)
    poles = poles_of_lines(find, clean.freq, *_pole_finder_data(clean), orders)
    if not len(poles.order):
        return None
    stability = stabilise(poles)
    selection = select(poles, stability)
    start = _starting_poles(selection, band_data, leaked)
    refined = _refined(band_data, clean, start, damping, leaked, part(progress, RANGES.pole_share, 1.0))
    if refined is None:
        return None
    fit, between = refined.fit, between_ends(refined.fit, band_data.freq)
    match = _match(selection, fit, band_data.freq)
    residual_modes, doubts = _residual_modes(refined), _doubts(fit, band_data.freq)
    if leaked is None:  # with leakage, reference modes need no column
        shown = np.isin(np.arange(len(between)), match) | residual_modes | _with_peaks(fit, clean)
        doubts = [doubt or ("" if seen else NOT_SHOWN) for doubt, seen in zip(doubts, shown, strict=True)]
    modes = between & np.array([not doubt for doubt in doubts], bool)
    return RangeModes(
        fit,
        refined.weight,
        _chart(poles, stability, selection, match),
        tuple(_reason(selection, match, m, residual_modes[m]) for m in range(len(fit.eigenvalue))),
        modes,
        between & ~modes,
        tuple(doubts),
        _no_modes((*selection.left_out, *refined.left_out), fit, modes),
        refined.drifts,
        refined.leakage_bias,
    )


def _refined(
    band_data: BandData,
    clean: BandData,
    start: StartingPoles,
    damping: Damping,
    leaked: LeakageCorrection | None,
    progress: Progress,
) -> RefinedModes | None:
    """Return the fit of all modes to `clean`, lines corrected for leakage; None without a mode."""
    if not len(start.eigenvalue):
        return None
    search = refine_with_search if leaked is None else refine  # leakage leaves more than noise
    refined = search(clean, start, damping, progress)
    if refined is None or leaked is None:
        return refined
    return with_leakage_errors(refined, band_data, leaked, damping)


def _starting_poles(
    selection: Selection, band_data: BandData, leaked: LeakageCorrection | None
) -> StartingPoles:
    """Return the selected poles, and with leakage its reference modes, as initial values of the fit."""
    eigenvalue = np.asarray(selection.frequency**2 * (2 * np.pi) ** 2 * (1 + 1j * selection.loss_factor))
    start = StartingPoles(eigenvalue, None if band_data.n_ref == 1 else selection.participation)
    return start if leaked is None else all_starts(start, leaked, band_data.freq)


def _residual_modes(refined: RefinedModes) -> BoolArray:
    """Return which modes of a fit were found in the residual of an earlier one, (n_modes,)."""
    frequency = refined.fit.frequency
    found = np.zeros(len(frequency), bool)
    for lower, upper in refined.residual_modes:
        found |= (frequency >= lower) & (frequency <= upper)
    return found


def _no_modes(left_out: Sequence[DoubtfulMode], fit: ModalFit, modes: BoolArray) -> tuple[DoubtfulMode, ...]:
    """Return the poles left out on the way that are not at a mode of the result."""
    frequency, width = fit.frequency[modes], (fit.loss_factor * fit.frequency)[modes]
    return tuple(
        pole
        for pole in left_out
        if not (np.abs(frequency - pole.frequency) < RANGES.match_distance * width).any()
    )


def _doubts(fit: ModalFit, freq: FloatArray) -> list[str]:
    """Return why each pole cannot be a mode wherever it lies in the range, as text; empty where it can."""
    spacing = float(np.median(np.diff(freq)))
    doubts = []
    for frequency, loss_factor in zip(fit.frequency, fit.loss_factor, strict=True):
        if loss_factor <= 0:
            doubts.append("residual pole with negative damping")
        elif frequency < RANGES.rigid_body_lines * spacing:
            doubts.append(
                "residual pole among the lowest lines above 0 Hz, where rigid bodies and drift prevail"
            )
        elif not freq[0] + spacing < frequency < freq[-1] - spacing:
            doubts.append("residual pole at the edge of the range, where the lines show one flank only")
        else:
            doubts.append("")
    return doubts


def _pole_finder_data(band_data: BandData) -> tuple[ComplexArray, FloatArray]:
    """Return mobility and its weights for a pole finder, (n_lines, n_dof, n_ref).

    Many DoFs are replaced by their principal components, with each DoF relative to its noise, so that the
    noise of the components is equal.
    """
    n_ref = band_data.n_ref
    omega = 2 * np.pi * band_data.freq[:, None]
    mobility, weight = 1j * omega * band_data.receptance, band_data.weight / omega**2
    # lines of all references are stacked, so that a combination of DoFs is common to all references
    mobility, weight = stack_references(mobility, n_ref), stack_references(weight, n_ref)
    if mobility.shape[1] > RANGES.largest_dofs:
        used = weight > 0
        noise = (used / np.where(used, weight, 1.0)).sum(axis=0) / np.maximum(used.sum(axis=0), 1)
        level = 1 / np.sqrt(np.where(noise > 0, noise, np.inf))
        normalised = np.where(used, mobility, 0) * level
        _, _, directions = np.linalg.svd(normalised.conj().T @ normalised, hermitian=True)
        components = directions[: RANGES.largest_dofs]
        variance = np.where(used, 1 / np.where(used, weight, 1.0), 0.0) * level**2 @ np.abs(components.T) ** 2
        determined = variance > 0
        mobility = normalised @ components.conj().T
        weight = np.where(determined, 1 / np.where(determined, variance, 1.0), 0.0)
    shape = (len(band_data.freq), n_ref, -1)
    by_reference = np.asarray(mobility, complex).reshape(shape).transpose(0, 2, 1)
    return by_reference, weight.reshape(shape).transpose(0, 2, 1)


def _match(selection: Selection, fit: ModalFit, freq: FloatArray) -> IntArray:
    """Return the fitted mode of each selected pole, -1 for none."""
    if not len(selection.pole):
        return np.zeros(0, int)
    width = fit.loss_factor * fit.frequency
    reach = np.maximum(width, RANGES.match_spacing * float(np.median(np.diff(freq))))
    distance = np.abs(selection.frequency[:, None] - fit.frequency) / reach
    nearest = distance.argmin(axis=1)
    # of modes at one frequency each has its own
    row, assigned = scipy.optimize.linear_sum_assignment(np.minimum(distance, RANGES.match_distance))
    close = distance[row, assigned] < RANGES.match_distance
    nearest[row[close]] = assigned[close]
    near = distance[np.arange(len(nearest)), nearest] < RANGES.match_distance
    return np.where(near, nearest, -1)


def _with_peaks(fit: ModalFit, band_data: BandData) -> BoolArray:
    """Return which modes are nearest to a peak of the lines, or overlap such a mode and are as narrow."""
    mobility = band_data.freq[:, None] * band_data.receptance
    try:
        bands = find_bands(mode_indicator(mobility, np.ones(len(mobility), bool)))
    except NoModeInBandError:
        return np.zeros(len(fit.frequency), bool)
    peaks = band_data.freq[[band.peak for band in bands]]
    nearest = np.abs(peaks[:, None] - fit.frequency).argmin(axis=1)
    width = fit.loss_factor * fit.frequency
    distance = np.abs(fit.frequency[:, None] - fit.frequency[nearest])
    near = distance <= SELECTION.pair_distance * np.minimum(width[:, None], width[nearest])
    narrow = width[:, None] <= RANGES.largest_width_ratio * width[nearest]
    return np.asarray((near & narrow).any(axis=1))


def _chart(poles: Poles, stability: IntArray, selection: Selection, match: IntArray) -> StabilisationChart:
    chart = chart_of(poles, stability, selection)
    mode = np.append(match, -1)[selection.mode]  # -1 finds the -1 at the end
    return StabilisationChart(chart.order, chart.frequency, chart.loss_factor, chart.stability, mode)


def _reason(selection: Selection, match: IntArray, mode: int, from_residual: bool) -> str:
    reasons = [selection.reasons[m] for m in np.flatnonzero(match == mode)]
    other = FROM_RESIDUAL if from_residual else "required by the fit in addition to the other modes"
    return "; ".join(reasons) or other


def pair_flags(fit: ModalFit, among: Sequence[int]) -> dict[int, list[str]]:
    """Return flags of modes that overlap with others."""
    width = fit.loss_factor * fit.frequency
    flags = {row: [text] for row, text in coincidence_flags(fit).items() if row in among}
    for r in among:
        for s in among:
            gap = abs(fit.frequency[r] - fit.frequency[s]) / max(width[r], width[s])
            if r != s and gap < SELECTION.pair_distance:
                covariance = fit.eigenvalue_covariance[r, s]
                correlation = covariance / max(fit.frequency_error[r] * fit.frequency_error[s], SAFE_DIVISOR)
                text = f"pair: with {fit.frequency[s]:.5g} Hz, {gap:.2g} bandwidths away"
                flags.setdefault(r, []).append(
                    f"{text}, correlation of the frequency errors {correlation:+.2f}"
                )
    return flags
