"""Modes by global methods: poles of all FRFs together, one fit of all modes, with honest errors."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NoReturn

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import NoModeInBandError
from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, part, silent
from modallab.extraction.averaging.damping_model_flag import with_damping_model_flags
from modallab.extraction.averaging.duplicate_modes import with_duplicate_flags
from modallab.extraction.averaging.notes import inconsistency_notes
from modallab.extraction.averaging.resynthesis import with_resynthesis
from modallab.extraction.multi_mode.frequency_ranges import Chart, find_frequency_ranges, orders_of
from modallab.extraction.multi_mode.global_method import GlobalMethod
from modallab.extraction.multi_mode.global_model import GlobalFit, modal_model
from modallab.extraction.multi_mode.leakage_correction import LeakageCorrection, leakage_correction
from modallab.extraction.multi_mode.out_of_band_modes import out_of_band_poles
from modallab.extraction.multi_mode.range_modes import modes_of
from modallab.extraction.multi_mode.refinement import BandData
from modallab.extraction.options import Damping, DistantLinesOptions, ExtractionOptions, GlobalOptions
from modallab.extraction.preprocessing.bands import Band, mode_indicator
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.preprocessing.line_noise import has_coherence, line_weights
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.single_mode.method import EXTRACTION_METHODS
from modallab.extraction.single_mode.plan import damping_choice
from modallab.extraction.single_mode_extraction import SMEARED, extract_mode_by_mode

BEGIN = "dobson"  # undoes leakage of modes apart
WITNESSES = 24  # FRFs that tell whether all are of one structure
# Shares of the time, of many FRFs: modes one by one, of some FRFs or where lines leak of all, and all fits
BEGUN, BEGUN_LEAKED, FITTED = 0.1, 0.6, 0.95


def extract_globally(
    find: GlobalMethod,
    responses: Responses,
    options: GlobalOptions,
    *,
    method: str,
    bands: Sequence[tuple[float, float]] | None,
    n_modes: int | None,
    leakage: WindowLeakage | None,
    bias: FloatArray | float = 0.0,
    progress: Progress = silent,
) -> ModalModel:
    """Return the modes that a global method finds.

    Poles of rising orders make a stabilisation chart; of its columns those are taken that `select` can give
    reasons for. All modes of a range are then fitted to all FRFs at once, weighted by the random error of
    each line, and those that no FRF shows beyond it are left out. Frequencies, loss factors and modal
    constants are those of the fit; the poles of the chart are only where it starts.

    Parameters
    ----------
    find
        A member of `GLOBAL_METHODS`.
    responses
        From `responses_of`.
    bands
        Pairs (lower, upper) in Hz, each with one mode or more; by default all from the first line that is
        more than noise to the last.
    n_modes
        How many to keep, the most prominent ones.
    leakage
        As of `extract`.
    bias
        (n_freq, n_frf), relative, that the lines may have beside their random error.

    Raises
    ------
    NoModeInBandError
        If a band given holds no mode, or no mode is found at all.
    """
    indicator = mode_indicator(responses.mobility, responses.coherent)
    searched = find_frequency_ranges(responses, indicator, bands)
    ranges = searched.ranges
    begun = BEGUN if leakage is None else BEGUN_LEAKED
    alone = _one_by_one(
        responses, options, leakage, slice(ranges[0].start, ranges[-1].stop), part(progress, 0.0, begun)
    )
    charts = [Chart(lines, *orders_of(indicator[lines], options)) for lines in ranges]
    fits = _fits(
        find,
        responses,
        line_weights(responses, bias),
        charts,
        options.law,
        leaked=None
        if leakage is None
        else leakage_correction(leakage, alone, responses.drive_row, responses.averages),
        given=bands is not None,
        progress=part(progress, begun, FITTED),
    )
    progress(FITTED, "modes of all FRFs")
    choices = {
        "max_order": charts[-1].why,
        "damping": damping_choice(options),
        "range": searched.said(responses.freq),
    }
    model = modal_model(fits, responses, method=method, n_modes=n_modes, choices=choices)
    model = with_duplicate_flags(model, alone)
    model = replace(
        model,
        notes=(
            *searched.left_out,
            *_not_of_one_structure(alone),
            *_empty(responses.freq, ranges, fits),
            *model.notes,
        ),
    )
    return with_resynthesis(
        with_damping_model_flags(model, responses, options),
        responses,
        [Band(fit.lines.start, fit.lines.stop - 1, fit.lines.start) for fit in fits],
        smeared=0 if leakage is None else SMEARED,
        beyond=out_of_band_poles(fits, responses.freq),
    )


def _fits(
    find: GlobalMethod,
    responses: Responses,
    weights: FloatArray,
    charts: Sequence[Chart],
    damping: Damping,
    *,
    leaked: LeakageCorrection | None,
    given: bool,
    progress: Progress,
) -> list[GlobalFit]:
    """Return the modes of each range that has some; raise where one that was given holds none."""
    fits: list[GlobalFit] = []
    known, n_ref = has_coherence(responses), len(responses.references)
    for number, chart in enumerate(charts):
        here = part(progress, number / len(charts), (number + 1) / len(charts))
        freq, lines = responses.freq[chart.lines], chart.lines
        stretch = BandData(freq, responses.receptance[lines], weights[lines], known, n_ref)
        found = modes_of(find, stretch, chart.orders, damping, leaked=leaked, progress=here)
        if found is not None and found.inside.any():
            fits.append(GlobalFit(lines, found))
        elif given:
            _none_in(freq, given=given)
    if not fits:
        _none_in(responses.freq, given=given)
    return fits


def _one_by_one(
    responses: Responses,
    options: ExtractionOptions,
    leakage: WindowLeakage | None,
    lines: slice,
    progress: Progress,
) -> ModalModel | None:
    """Return modes as a method sees them that takes them and the FRFs one by one; None if it sees none.

    Where nothing leaks some of the FRFs and the lines asked for will do: they only have to say whether they
    are of one structure.
    """
    try:
        return extract_mode_by_mode(
            EXTRACTION_METHODS[BEGIN],
            responses if leakage is not None else _some(_within(responses, lines)),
            DistantLinesOptions(damping=options.law),
            method=BEGIN,
            bands=None,
            n_modes=None,
            leakage=leakage,
            progress=progress,
        )
    except NoModeInBandError:
        return None


def _some(responses: Responses) -> Responses:
    """Return the FRFs, of many those of some DoFs, evenly among them, and of the drive points."""
    n, n_ref = len(responses.dofs), len(responses.references)
    most = max(WITNESSES // n_ref, 1)
    rows = np.unique(np.linspace(0, n - 1, min(n, most)).round().astype(int))
    rows = np.union1d(rows, responses.driving[responses.driving >= 0])
    frfs = (rows[:, None] * n_ref + np.arange(n_ref)).ravel()
    return replace(
        responses,
        receptance=responses.receptance[:, frfs],
        coherence=responses.coherence[:, frfs],
        dofs=tuple(responses.dofs[row] for row in rows),
    )


def _within(responses: Responses, lines: slice) -> Responses:
    return replace(
        responses,
        freq=responses.freq[lines],
        receptance=responses.receptance[lines],
        coherence=responses.coherence[lines],
    )


def _not_of_one_structure(alone: ModalModel | None) -> Iterator[str]:
    """Yield a warning where FRFs have no poles in common, and what moves them."""
    if alone is None or alone.wander is None:
        return
    cause, *_ = inconsistency_notes(alone.wander, alone.frfs)
    yield f"a global method takes all FRFs to be of one structure, and these are not: {cause}"
    followers = ", ".join(name for name, method in EXTRACTION_METHODS.items() if method.exact)
    yield (
        "modes may be split or doubled here (flags say so where a cause is found); methods that fit each FRF "
        f"by itself follow them and tell how far they move: {followers}"
    )


def _empty(freq: FloatArray, ranges: Sequence[slice], fits: Sequence[GlobalFit]) -> Iterator[str]:
    """Yield which ranges hold no mode."""
    for lines in ranges:
        if not any(fit.lines == lines for fit in fits):
            yield f"no mode is found from {freq[lines][0]:g} to {freq[lines][-1]:g} Hz"


def _none_in(freq: FloatArray, *, given: bool) -> NoReturn:
    lower, upper = float(freq[0]), float(freq[-1])
    what = f"no FRF shows a mode between {lower:g} and {upper:g} Hz"
    if given:
        raise NoModeInBandError(what, field="bands", lower=lower, upper=upper)
    raise NoModeInBandError("no resonance stands out of the FRFs", field="bands")
