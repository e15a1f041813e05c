"""Notes on the averages, the inconsistency of frequencies, and outliers."""

from collections.abc import Iterator, Sequence

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.frequency_inconsistency import FrequencyInconsistency, InconsistencyCause
from modallab.extraction.averaging.reference_shapes import ReferenceShapes
from modallab.extraction.averaging.settings import SHARED_NOISE
from modallab.extraction.single_mode.fit_table import FitTable


def choice_of_means(inconsistency: FrequencyInconsistency | None, noise_correlation: FloatArray) -> str:
    """Return the kind of averages over FRFs, with its reason; correlation of FRFs (n_modes,) of each mode."""
    least, most = (f"{100 * part(noise_correlation):.0f}" for part in (np.min, np.max))
    percent = most if least == most else f"{least} to {most}"
    return _means(inconsistency) + (
        f"; {percent} % of their random error is common to all FRFs and is not reduced by the mean"
        if noise_correlation.max(initial=0.0) > SHARED_NOISE.noted_fraction
        else ""
    )


def _means(inconsistency: FrequencyInconsistency | None) -> str:
    if inconsistency is None:
        return (
            "weighted by inverse variance: the frequencies of the FRFs agree within their standard errors, "
            "as expected of one structure"
        )
    if inconsistency.cause is InconsistencyCause.UNKNOWN:
        return (
            "unweighted for modes whose FRFs differ by more than their standard errors, with errors from the "
            "scatter; weighted by inverse variance for the other modes"
        )
    return "unweighted: every FRF belongs to a slightly different structure"


def no_scale(shapes: ReferenceShapes) -> Iterator[str]:
    """Yield a note where there is no drive-point response."""
    if shapes.scale is None:
        drive_points = ", ".join(str(dof) for dof in shapes.references)
        designation = "the drive point" if len(shapes.references) == 1 else "any of the drive points"
        yield f"no response at {designation} {drive_points}: shapes are not mass-normalised"


def inconsistency_notes(inconsistency: FrequencyInconsistency | None, names: Sequence[str]) -> Iterator[str]:
    """Yield the cause of inconsistent frequencies, and the range of each mode."""
    if inconsistency is None:
        return
    total, degrees = float(inconsistency.chi_square.sum()), int(inconsistency.degrees.sum())
    yield (
        f"natural frequencies differ between FRFs by more than their standard errors "
        f"(chi-square {total:.3g} of {degrees} degrees of freedom): {_cause(inconsistency)}"
    )
    for number, shift in enumerate(inconsistency.shift, start=1):
        if (text := _range(shift, names)) is not None:
            yield f"mode {number} shifts {text}"


def _cause(inconsistency: FrequencyInconsistency) -> str:
    share = f"explains {100 * inconsistency.explained:.0f} % of it"
    match inconsistency.cause:
        case InconsistencyCause.ROVING_MASS:
            mass, error = 1e3 * inconsistency.size, 1e3 * inconsistency.size_error
            size = f"{mass:.3g} +- {error:.2g} g"
            if mass < 0:
                return (
                    f"they rise with the squared shape at the response, as with a roving mass of {size} "
                    f"({share})"
                )
            return (
                f"they fall with the squared shape at the roving accelerometer: a mass of {size} at its "
                f"position {share}"
            )
        case InconsistencyCause.SQUARED_SHAPE:
            return (
                f"they vary with the squared shape at the response, as with a roving mass, which {share}; "
                "the mass itself cannot be determined from shapes without scale"
            )
        case InconsistencyCause.STEADY_DRIFT:
            change, error = 100 * inconsistency.size, 100 * inconsistency.size_error
            return (
                f"all modes drift by {change:+.3g} +- {error:.2g} % from the first FRF to the last, "
                f"which {share}: the structure changes during the test, for instance with temperature"
            )
        case InconsistencyCause.UNKNOWN:
            return (
                "they follow neither the squared shape at the response nor a steady drift; possible "
                "causes are leakage, close modes, or a structure that changes from FRF to FRF"
            )


def _range(shift: FloatArray, names: Sequence[str]) -> str | None:
    identified = np.flatnonzero(np.isfinite(shift))
    if len(identified) < 2:
        return None
    low, high = identified[np.argmin(shift[identified])], identified[np.argmax(shift[identified])]
    return (
        f"by {shift[high] - shift[low]:.3g} Hz: {shift[low]:+.3g} Hz from its mean at {names[low]}, "
        f"{shift[high]:+.3g} Hz at {names[high]}"
    )


def why_outlying(table: FitTable, order: IntArray, names: Sequence[str]) -> Iterator[str]:
    """Yield the distance of each outlier from the accepted fits; `order` are the modes as listed."""
    for number, m in enumerate(order.tolist(), start=1):
        good = table.screening.good[m]
        frequency, damping = np.median(table.frequency[m][good]), np.median(table.loss_factor[m][good])
        for j in np.flatnonzero(table.screening.outlying[m]).tolist():
            off = table.frequency[m, j] - frequency
            share = 100 * (table.loss_factor[m, j] / damping - 1)
            yield (
                f"mode {number}, {names[j]} left out: {off:+.3g} Hz from the median of the others (its "
                f"standard error {table.frequency_error[m, j]:.2g} Hz), loss factor {share:+.0f} %"
            )
