"""Extraction by single-mode methods: one band for each mode, one window in each FRF, averages over FRFs."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import NoModeInBandError
from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, part, silent
from modallab.extraction.averaging.combine import combine_fits
from modallab.extraction.averaging.damping_model_flag import with_damping_model_flags
from modallab.extraction.averaging.misfit_flags import flag_further_peaks, flag_misfits
from modallab.extraction.averaging.resynthesis import with_resynthesis
from modallab.extraction.averaging.shared_noise import shared_noise_fraction
from modallab.extraction.options import SingleModeOptions
from modallab.extraction.preprocessing.bands import Band, mode_indicator, requested_bands
from modallab.extraction.preprocessing.common_peaks import CommonPeaks, find_common
from modallab.extraction.preprocessing.fit_windows import Windows, place_windows
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.preprocessing.line_noise import has_coherence
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.settings import NOTES
from modallab.extraction.single_mode.correlated_fits import with_correlated_errors
from modallab.extraction.single_mode.damping_models import DAMPING_MODELS, DampingModel
from modallab.extraction.single_mode.fit_data import FitData, window_data
from modallab.extraction.single_mode.fit_table import ConvergedFits, FitTable
from modallab.extraction.single_mode.fitting import fit_all
from modallab.extraction.single_mode.leaked_covariance import line_accuracy
from modallab.extraction.single_mode.leaked_fits import with_leakage_errors
from modallab.extraction.single_mode.method import ExtractionMethod, SingleModeMethod
from modallab.extraction.single_mode.plan import Plan, plan


def extract_mode_by_mode(
    registered: SingleModeMethod,
    responses: Responses,
    options: SingleModeOptions,
    *,
    method: str,
    bands: Sequence[tuple[float, float]] | None,
    n_modes: int | None,
    leakage: WindowLeakage | None,
    progress: Progress = silent,
) -> ModalModel:
    """Return the modes by a single-mode method; parameters and errors as in `extract`."""
    freq, dofs = responses.freq, responses.dofs
    damping_model = DAMPING_MODELS[options.assumed_damping]
    fit, line_choice = registered.with_options(options), plan(options, leakage)
    progress(0.0, "looking for modes")
    indicator = mode_indicator(responses.mobility, responses.coherent)
    peaks = _peaks(responses, indicator, bands, n_modes)
    fit_bands = peaks.bands
    windows = _windows(responses, indicator, fit_bands, line_choice)
    progress(0.2, f"fitting {len(fit_bands)} modes in {len(dofs)} FRFs")
    data = window_data(freq, responses.receptance, responses.variance, windows, leakage, responses.drive_row)
    settled = fit_all(fit, damping_model, data, progress=part(progress, 0.2, 0.9))
    settled = _with_line_errors(settled, fit, damping_model, data, responses, windows.index, leakage)
    table = replace(settled.table, lines=windows.ends)
    notes = [*peaks.notes, *_empty_band_notes(table, freq, fit_bands, requested=bands is not None)]
    notes += _choice_notes(registered, method, windows, line_choice)
    notes += _number_notes(len(fit_bands), n_modes if bands is None else None)
    progress(1.0, "modes averaged")
    noise = responses.noise if len(responses.references) == 1 else None
    model = combine_fits(
        table,
        dofs,
        responses.references,
        method=method,
        notes=notes,
        choices=line_choice.choices,
        noise_correlation=shared_noise_fraction(damping_model, data, settled, windows.index, noise),
    )
    if leakage is None and registered.exact:
        model = flag_misfits(model, responses, damping_model, line_choice.leave_out)
    if bands is not None:
        model = flag_further_peaks(model, freq, indicator, fit_bands)
    model = with_damping_model_flags(model, responses, options)
    return with_resynthesis(
        model, responses, fit_bands, smeared=0 if leakage is None else NOTES.smeared_lines
    )


def _peaks(
    responses: Responses,
    indicator: FloatArray,
    bands: Sequence[tuple[float, float]] | None,
    n_modes: int | None,
) -> CommonPeaks:
    """Return the peaks common to the FRFs, or those of the requested bands."""
    if bands is None:
        return find_common(responses, indicator, n_modes)
    return CommonPeaks(requested_bands(responses.freq, indicator, bands))


def _windows(
    responses: Responses, indicator: FloatArray, bands: Sequence[Band], line_choice: Plan
) -> Windows:
    """Return the lines of each fit about its resonance."""
    return place_windows(
        responses.mobility,
        indicator,
        bands,
        base=line_choice.lines,
        widths=line_choice.widths,
        leave_out=line_choice.leave_out,
    )


def _with_line_errors(
    settled: ConvergedFits,
    fit: ExtractionMethod,
    damping_model: DampingModel,
    data: FitData,
    responses: Responses,
    index: IntArray,
    leakage: WindowLeakage | None,
) -> ConvergedFits:
    """Return the fits with standard errors that include leakage, or the correlation of the lines."""
    if leakage is not None:
        accuracy = line_accuracy(responses, index) if has_coherence(responses) else None
        return with_leakage_errors(fit, damping_model, data, leakage, settled, accuracy)
    if responses.correlation is not None:
        return with_correlated_errors(fit, damping_model, data, settled, responses, index)
    return settled


def _number_notes(number: int, n_modes: int | None) -> Iterator[str]:
    """Yield a note if fewer modes were found than requested."""
    if n_modes is not None and number < n_modes:
        yield f"{n_modes} modes requested, {number} found"


def _choice_notes(
    registered: SingleModeMethod, method: str, windows: Windows, line_choice: Plan
) -> Iterator[str]:
    """Yield notes on the method and on the lines that its fits use."""
    if not registered.exact:
        yield f"{method} is biased: up to half a line in frequency, and too much damping"
    window_lines = np.diff(windows.ends, axis=2)[:, :, 0] // windows.stride[:, None] + 1
    left_out = window_lines - windows.used.sum(axis=2)
    if (left_out < line_choice.leave_out).any():
        yield f"in bands of few lines, fewer than {line_choice.leave_out} lines were left out"
    if (thinned := windows.stride > 1).any():
        yield (
            f"{thinned.sum()} modes are so wide that fits use every {windows.stride.max()}th line at most; "
            "a global method uses all lines"
        )


def _empty_band_notes(
    table: FitTable, freq: FloatArray, bands: Sequence[Band], *, requested: bool
) -> list[str]:
    """Return a note on every band without a mode.

    Raises
    ------
    NoModeInBandError
        If a requested band has no mode, or no band has one.
    """
    line_accuracy = np.asarray(table.screening.good.any(axis=1))
    empty = [band for band, has_mode in zip(bands, line_accuracy.tolist(), strict=True) if not has_mode]
    if empty and not requested and not line_accuracy.any():
        raise NoModeInBandError(
            f"no FRF shows a mode at any of {len(empty)} peaks beyond its random error; bands may help",
            field="bands",
            value=[f"{freq[band.peak]:g}" for band in empty[: NOTES.listed_peaks]],
        )
    if empty and requested:
        lower, upper = float(freq[empty[0].first]), float(freq[empty[0].last])
        raise NoModeInBandError(
            f"no FRF shows a mode by itself between {lower:g} and {upper:g} Hz",
            field="bands",
            lower=lower,
            upper=upper,
        )
    peaks = [f"{freq[band.peak]:g}" for band in empty]
    if len(peaks) > NOTES.listed_peaks:
        return [
            f"{len(peaks)} peaks from {peaks[0]} to {peaks[-1]} Hz are no modes: noise, or bands are needed"
        ]
    return [f"a peak at {peak} Hz is no mode" for peak in peaks]
