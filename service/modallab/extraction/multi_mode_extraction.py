"""Extraction by global methods: poles of all FRFs, one fit of all modes, standard errors."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NoReturn

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import NoModeInBandError
from modallab.core.frequency_inconsistency import InconsistencyCause
from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, part, silent
from modallab.extraction.averaging.damping_model_flag import with_damping_model_flags
from modallab.extraction.averaging.duplicate_modes import drift_ranges, with_duplicate_flags
from modallab.extraction.averaging.notes import inconsistency_notes
from modallab.extraction.averaging.resynthesis import with_resynthesis
from modallab.extraction.multi_mode.frequency_ranges import (
    Chart,
    FrequencyRanges,
    find_frequency_ranges,
    orders_of,
)
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
from modallab.extraction.preprocessing.noise_model import NoiseModel
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.settings import NOTES, PROGRESS_SHARES
from modallab.extraction.single_mode.method import EXTRACTION_METHODS
from modallab.extraction.single_mode.plan import damping_choice
from modallab.extraction.single_mode_extraction import extract_mode_by_mode

STARTING_METHOD = "dobson"  # undoes leakage of modes apart
KnownModes = dict[tuple[int, int], ModalModel | None]
"""Modes by `STARTING_METHOD`, by first and last line.

Without leakage they only test whether the FRFs belong to one structure, for which those of either damping
model serve.
"""


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
    known: KnownModes | None = None,
    progress: Progress = silent,
) -> ModalModel:
    """Return the modal model identified by a global method.

    Poles at ascending orders form a stabilisation chart, and `select` accepts some of its columns as modes.
    All modes of a range are then fitted to all FRFs together, weighted by the random error of each line;
    insignificant modes are eliminated. Frequencies, loss factors and modal constants are those of this fit,
    whose initial values are the poles of the chart.

    Parameters
    ----------
    find
        A member of `GLOBAL_METHODS`.
    responses
        From `responses_of`.
    bands
        Pairs (lower, upper) in Hz, each with one mode or more; by default the range from the first to the
        last line above noise.
    n_modes
        Number of modes to keep, the most prominent ones.
    leakage
        As in `extract`.
    bias
        (n_freq, n_frf) relative bias of the lines in addition to their random error.
    known
        Single modes that an extraction of the same responses identified, and that it keeps for the next one.

    Raises
    ------
    NoModeInBandError
        If a requested band contains no mode, or no mode is found.
    """
    indicator = mode_indicator(responses.mobility, responses.coherent)
    search = find_frequency_ranges(responses, indicator, bands)
    ranges = search.ranges
    starting_share = PROGRESS_SHARES.single_modes if leakage is None else PROGRESS_SHARES.single_modes_leaked
    known = {} if known is None or leakage is not None else known
    lines, starting_progress = slice(ranges[0].start, ranges[-1].stop), part(progress, 0.0, starting_share)
    single_modes = _known_single_modes(known, responses, options, leakage, lines, starting_progress)
    charts = [Chart(lines, *orders_of(indicator[lines], options)) for lines in search.ranges]
    leaked = None
    if leakage is not None:
        leaked = leakage_correction(leakage, single_modes, responses.drive_row, responses.averages)
    fits = _fits(
        find,
        responses,
        line_weights(responses, bias),
        charts,
        options.assumed_damping,
        leaked=leaked,
        drifting=drift_ranges(single_modes),
        requested=bands is not None,
        progress=part(progress, starting_share, PROGRESS_SHARES.fits),
    )
    progress(PROGRESS_SHARES.fits, "modes of all FRFs")
    choices = {
        "max_order": charts[-1].why,
        "damping": damping_choice(options),
        "range": search.description(responses.freq),
    }
    model = modal_model(fits, responses, method=method, n_modes=n_modes, choices=choices)
    model = with_duplicate_flags(model, single_modes)
    model = _with_search_notes(model, search, single_modes, fits, responses)
    model = with_damping_model_flags(model, responses, options)
    return _with_resynthesised_lines(model, responses, fits, leakage)


def _with_resynthesised_lines(
    model: ModalModel, responses: Responses, fits: Sequence[GlobalFit], leakage: WindowLeakage | None
) -> ModalModel:
    """Return the model with its misfit at the lines of the fits."""
    return with_resynthesis(
        model,
        responses,
        [Band(fit.lines.start, fit.lines.stop - 1, fit.lines.start) for fit in fits],
        smeared=0 if leakage is None else NOTES.smeared_lines,
        out_of_band_poles=out_of_band_poles(fits, responses.freq),
    )


def _with_search_notes(
    model: ModalModel,
    search: FrequencyRanges,
    single_modes: ModalModel | None,
    fits: Sequence[GlobalFit],
    responses: Responses,
) -> ModalModel:
    """Return the model with notes on lines left out, inconsistent frequencies and empty ranges."""
    notes = (
        *search.left_out,
        *_inconsistency_warning(single_modes),
        *_empty_range_notes(responses.freq, search.ranges, fits),
        *model.notes,
    )
    return replace(model, notes=notes)


def _fits(
    find: GlobalMethod,
    responses: Responses,
    weights: FloatArray,
    charts: Sequence[Chart],
    damping: Damping,
    *,
    leaked: LeakageCorrection | None,
    drifting: tuple[tuple[float, float], ...],
    requested: bool,
    progress: Progress,
) -> list[GlobalFit]:
    """Return the modes of each range that has some.

    Raises
    ------
    NoModeInBandError
        If a requested range has no mode, or no range has one.
    """
    fits: list[GlobalFit] = []
    weights_known, n_ref = has_coherence(responses), len(responses.references)
    for number, chart in enumerate(charts):
        range_progress = part(progress, number / len(charts), (number + 1) / len(charts))
        freq, lines = responses.freq[chart.lines], chart.lines
        noise, receptance = NoiseModel.of(responses, lines), responses.receptance[lines]
        band_data = BandData(freq, receptance, weights[lines], weights_known, n_ref, drifting, noise)
        modes = modes_of(find, band_data, chart.orders, damping, leaked=leaked, progress=range_progress)
        if modes is not None and modes.inside.any():
            fits.append(GlobalFit(lines, modes))
        elif requested:
            _raise_no_mode(freq, requested=requested)
    if not fits:
        _raise_no_mode(responses.freq, requested=requested)
    return fits


def _known_single_modes(
    known: KnownModes,
    responses: Responses,
    options: ExtractionOptions,
    leakage: WindowLeakage | None,
    lines: slice,
    progress: Progress,
) -> ModalModel | None:
    """Return modes as `_single_mode_model`, those of the same lines if they are known; keeps them."""
    if (lines.start, lines.stop) not in known:
        known[lines.start, lines.stop] = _single_mode_model(responses, options, leakage, lines, progress)
    return known[lines.start, lines.stop]


def _single_mode_model(
    responses: Responses,
    options: ExtractionOptions,
    leakage: WindowLeakage | None,
    lines: slice,
    progress: Progress,
) -> ModalModel | None:
    """Return modes by a single-mode method, FRF by FRF; None if there are none.

    Without leakage, some FRFs and the lines of the ranges suffice: they only test whether the FRFs belong to
    one structure.
    """
    try:
        return extract_mode_by_mode(
            EXTRACTION_METHODS[STARTING_METHOD],
            responses if leakage is not None else _subset_of_frfs(_subset_of_lines(responses, lines)),
            DistantLinesOptions(damping=options.assumed_damping),
            method=STARTING_METHOD,
            bands=None,
            n_modes=None,
            leakage=leakage,
            progress=progress,
        )
    except NoModeInBandError:
        return None


def _subset_of_frfs(responses: Responses) -> Responses:
    """Return the FRFs of at most some evenly chosen DoFs, and of the drive points."""
    n, n_ref = len(responses.dofs), len(responses.references)
    most = max(NOTES.consistency_frfs // n_ref, 1)
    rows = np.unique(np.linspace(0, n - 1, min(n, most)).round().astype(int))
    rows = np.union1d(rows, responses.driving[responses.driving >= 0])
    frfs = (rows[:, None] * n_ref + np.arange(n_ref)).ravel()
    return replace(
        responses,
        receptance=responses.receptance[:, frfs],
        coherence=responses.coherence[:, frfs],
        noise=None if responses.noise is None else responses.noise.of_frfs(frfs),
        dofs=tuple(responses.dofs[row] for row in rows),
    )


def _subset_of_lines(responses: Responses, lines: slice) -> Responses:
    return replace(
        responses,
        freq=responses.freq[lines],
        receptance=responses.receptance[lines],
        coherence=responses.coherence[lines],
        noise=None if responses.noise is None else responses.noise.at(lines),
    )


def _inconsistency_warning(single_modes: ModalModel | None) -> Iterator[str]:
    """Yield a warning where FRFs have no common poles, with the cause."""
    if single_modes is None or single_modes.frequency_inconsistency is None:
        return
    cause, *_ = inconsistency_notes(single_modes.frequency_inconsistency, single_modes.frfs)
    yield f"global methods assume that all FRFs belong to one structure, but here {cause}"
    followers = ", ".join(name for name, method in EXTRACTION_METHODS.items() if method.exact)
    drifting = single_modes.frequency_inconsistency.cause is InconsistencyCause.STEADY_DRIFT
    consequence = (
        "a mode that drifts is one mode, with a mean frequency"
        if drifting
        else "modes may be split or doubled (see the flags if a cause was found)"
    )
    yield (
        f"{consequence}; methods that fit each FRF separately determine the frequency of each FRF: "
        f"{followers}"
    )


def _empty_range_notes(freq: FloatArray, ranges: Sequence[slice], fits: Sequence[GlobalFit]) -> Iterator[str]:
    """Yield a note on every range without a mode."""
    for lines in ranges:
        if not any(fit.lines == lines for fit in fits):
            yield f"no mode was found from {freq[lines][0]:g} to {freq[lines][-1]:g} Hz"


def _raise_no_mode(freq: FloatArray, *, requested: bool) -> NoReturn:
    lower, upper = float(freq[0]), float(freq[-1])
    message = f"no FRF shows a mode between {lower:g} and {upper:g} Hz"
    if requested:
        raise NoModeInBandError(message, field="bands", lower=lower, upper=upper)
    raise NoModeInBandError("no resonance was found in the FRFs", field="bands")
