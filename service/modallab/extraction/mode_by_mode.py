"""Modes by single-mode methods: a band for each, a window in each FRF, one set collated from all fits."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import NoModeInBandError
from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, silent
from modallab.extraction.bands import Band, find_bands, given_bands, mode_indicator
from modallab.extraction.collate import collate
from modallab.extraction.fitting import Table, fit_all, gather
from modallab.extraction.leakage import Leakage
from modallab.extraction.method import ExtractionMethod
from modallab.extraction.options import ExtractionOptions
from modallab.extraction.responses import Responses
from modallab.extraction.windows import LEAKY_LINES, LINES, place_windows


def extract_mode_by_mode(
    fit: ExtractionMethod,
    responses: Responses,
    options: ExtractionOptions,
    *,
    method: str,
    bands: Sequence[tuple[float, float]] | None,
    n_modes: int | None,
    leakage: Leakage | None,
    progress: Progress = silent,
) -> ModalModel:
    """Return the modes that a single-mode method reads; parameters and errors as `extract`."""
    freq, dofs = responses.freq, responses.dofs
    progress(0.0, "looking for modes")
    indicator = mode_indicator(responses.mobility, responses.coherent)
    found = find_bands(indicator, n_modes) if bands is None else given_bands(freq, indicator, bands)
    base = options.lines or (LINES if leakage is None else LEAKY_LINES)
    windows = place_windows(responses.mobility, indicator, found, base=base)
    progress(0.2, f"fitting {len(found)} modes in {len(dofs)} FRFs")
    data = gather(freq, responses.receptance, responses.variance, windows, leakage, responses.drive_row)
    table = fit_all(fit, data)
    notes = _missing(table, freq, found, given=bands is not None)
    if n_modes is not None and bands is None and len(found) < n_modes:
        notes.append(f"{n_modes} modes asked for, {len(found)} found")
    progress(1.0, "modes collated")
    return collate(table, dofs, responses.drive, method=method, notes=notes)


def _missing(table: Table, freq: FloatArray, bands: Sequence[Band], *, given: bool) -> list[str]:
    """Return a note on every band found that proved empty; raise if it was given, or if all are."""
    seen = np.asarray(table.screening.good.any(axis=1))
    notes = []
    for band, shown in zip(bands, seen.tolist(), strict=True):
        lower, upper = float(freq[band.first]), float(freq[band.last])
        if not shown and (given or not seen.any()):
            raise NoModeInBandError(
                f"no FRF shows a mode between {lower:g} and {upper:g} Hz",
                field="bands",
                lower=lower,
                upper=upper,
            )
        if not shown:
            notes.append(f"a peak at {freq[band.peak]:g} Hz is no mode")
    return notes
