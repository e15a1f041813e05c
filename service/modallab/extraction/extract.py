"""The one way from measured responses to modes."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, NoModeInBandError
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, silent
from modallab.extraction.bands import Band, coherent_lines, find_bands, given_bands, mode_indicator
from modallab.extraction.collate import collate, drive_row
from modallab.extraction.fitting import Table, fit_all, gather
from modallab.extraction.leakage import Leakage
from modallab.extraction.method import EXTRACTION_METHODS, MIN_LINES
from modallab.extraction.windows import LEAKY_LINES, LINES, line_variance, place_windows

LARGEST = 1e60  # m/N


def extract(
    frf: FrfSet,
    *,
    coherence: FloatArray | None,
    averages: float,
    method: str = "dobson",
    bands: Sequence[tuple[float, float]] | None = None,
    n_modes: int | None = None,
    leakage: Leakage | None = None,
    progress: Progress = silent,
) -> ModalModel:
    """Return the modes that a set of FRFs shows.

    Parameters
    ----------
    frf
        One drive point and many responses, or one response and a roving drive point; any kind.
    coherence
        (n_freq, n_out), or (n_freq, n_out, n_in); None where it was not measured: then the misfit of
        the fits stands in for the random error.
    averages
        Effective number of averages behind the coherence.
    method
        A member of `EXTRACTION_METHODS`.
    bands
        Pairs (lower, upper) in Hz with one mode each; found from the FRFs by default.
    n_modes
        How many of the bands found to keep, the most prominent ones.
    leakage
        What window cut the random records and which estimator was used; None for records that are periodic,
        or die out, within the window.
    progress
        Told what is being done.

    Raises
    ------
    NoModeInBandError
        If a band given holds no mode, or no mode is found at all.
    InvalidInputError
        If the inputs do not fit together.
    """
    fit = EXTRACTION_METHODS[method]
    if n_modes is not None and n_modes < 1:
        raise InvalidInputError("at least one mode", field="n_modes", value=n_modes, allowed="1 or more")
    freq, receptance, trust, dofs, drive = _responses(frf, coherence, averages)
    progress(0.0, "looking for modes")
    mobility = 2j * np.pi * freq[:, None] * receptance * np.sqrt(trust)
    indicator = mode_indicator(mobility, coherent_lines(trust, averages))
    found = find_bands(indicator, n_modes) if bands is None else given_bands(freq, indicator, bands)
    base = LINES if leakage is None else LEAKY_LINES
    windows = place_windows(mobility, indicator, found, base=base)
    progress(0.2, f"fitting {len(found)} modes in {len(dofs)} FRFs")
    variance = line_variance(receptance, trust, averages)
    table = fit_all(fit, gather(freq, receptance, variance, windows, leakage, drive_row(dofs, drive)))
    notes = _missing(table, freq, found, given=bands is not None)
    if n_modes is not None and bands is None and len(found) < n_modes:
        notes.append(f"{n_modes} modes asked for, {len(found)} found")
    progress(1.0, "modes collated")
    return collate(table, dofs, drive, method=method, notes=notes)


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


def _responses(
    frf: FrfSet, coherence: FloatArray | None, averages: float
) -> tuple[FloatArray, ComplexArray, FloatArray, tuple[Dof, ...], Dof]:
    """Return the axis above 0 Hz, receptance and coherence (n_freq, n_frf), their DoFs, the fixed DoF."""
    n_out, n_in = len(frf.outputs), len(frf.inputs)
    if min(n_out, n_in) != 1:
        raise InvalidInputError(
            "modes are read from one drive point, or one response with a roving drive point",
            field="inputs",
            value=f"{n_out} x {n_in}",
            allowed="one input or one output",
        )
    if not averages > 0:
        raise InvalidInputError(
            "averages must be above zero", field="averages", value=averages, allowed="> 0"
        )
    trust = _coherence(frf, coherence)
    above = frf.freq > 0
    usable = frf.between(0.0, np.inf).to(FrfKind.RECEPTANCE)
    values = usable.values.reshape(len(usable.freq), -1)
    size = float(np.abs(values).max(initial=0.0))
    if size and not 1 / LARGEST < size < LARGEST:  # their squares must still be numbers
        raise InvalidInputError(
            "the FRFs are of no physical size", field="values", value=size, allowed=f"below {LARGEST:g} m/N"
        )
    if len(usable.freq) < MIN_LINES:
        raise InvalidInputError(
            "too few lines", field="freq", value=len(usable.freq), allowed=f"at least {MIN_LINES} above 0 Hz"
        )
    roving, fixed = (frf.outputs, frf.inputs[0]) if n_in == 1 else (frf.inputs, frf.outputs[0])
    return usable.freq, values, trust[above], roving, fixed


def _coherence(frf: FrfSet, coherence: FloatArray | None) -> FloatArray:
    """Return the coherence, (n_freq, n_frf), checked; 1 where it is not known."""
    n_freq, n_out, n_in = frf.values.shape
    if coherence is None:
        return np.ones((n_freq, n_out * n_in))
    if coherence.shape not in ((n_freq, n_out), (n_freq, n_out, n_in)) or (
        coherence.size != n_freq * n_out * n_in
    ):
        raise InvalidInputError(
            "coherence does not fit the FRFs",
            field="coherence",
            value=str(coherence.shape),
            allowed=str((n_freq, n_out, n_in)),
        )
    bad = ~((coherence >= 0) & (coherence <= 1 + 1e-9))
    if bad.any():
        raise InvalidInputError(
            "coherence must lie from 0 to 1",
            field="coherence",
            value=float(coherence[bad][0]),
            allowed="0 to 1",
        )
    return np.minimum(coherence, 1.0).reshape(n_freq, -1)
