"""Reciprocity checks: exchange of force and response between two points.

Two FRFs between the same two points, measured in both directions, are compared line by line (`reciprocity`).
A roving hammer with several accelerometers gives such pairs among the points that have an accelerometer and
were struck. Two tests with different drive points, each with the other's drive point among its responses,
give one pair, which is also compared mode by mode (`modal_reciprocity`). One drive point with its responses,
or one response with a roving hammer, gives no pair. A linear structure that does not rotate is reciprocal.
"""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.common_dofs import common_points, rows_at
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.preprocessing.fit_windows import line_variance
from modallab.extraction.preprocessing.settings import RECIPROCITY


@dataclass(frozen=True, eq=False)
class Reciprocity:
    """Comparison of pairs of FRFs between the same points; every array (n_pairs,)."""

    pairs: tuple[tuple[Dof, Dof], ...]
    """Degrees of freedom (j, k): H_jk, response at j, is compared with H_kj."""
    scale: ComplexArray
    """Least-squares factor in H_jk = scale H_kj: 1 if reciprocal, -1 if a sign is wrong."""
    difference: FloatArray
    """Root mean square of H_jk - H_kj over that of their mean."""
    misfit: FloatArray
    """Mean of |H_jk - H_kj|^2 over its variance: 1 for random error only; NaN where the variance is
    unknown."""
    differs: BoolArray
    """True where the difference exceeds the random error."""
    note: str
    """Statement of the pairs that the data contain."""


def reciprocity(
    frf: FrfSet, *, coherence: FloatArray | None = None, averages: float | None = None
) -> Reciprocity:
    """Return the comparison of every two FRFs between the same points.

    Sums extend over all lines above 0 Hz of the FRFs as given: inertance gives more weight to high
    frequencies, receptance to low ones. The random errors of the two are taken as independent; noise of a
    force transducer common to both makes them differ by less.

    Parameters
    ----------
    frf
        Any number of outputs and inputs, of any kind.
    coherence
        (n_freq, n_out, n_in) of each FRF; None if unknown.
    averages
        Effective number of averages of the coherence.

    Raises
    ------
    InvalidInputError
        If the coherence does not have the shape of the FRFs, or is given without averages.
    """
    points = common_points(frf.outputs, frf.inputs)
    pairs = [(a, b) for n, a in enumerate(points) for b in points[n + 1 :]]
    positive = frf.freq > 0
    variance = _variance(frf, coherence, averages)[positive]
    out, signs_out = rows_at(frf.outputs, points)
    into, signs_in = rows_at(frf.inputs, points)
    values = frf.values[positive][:, out][:, :, into] * np.outer(signs_out, signs_in)
    variance = variance[:, out][:, :, into]
    rows, columns = np.triu_indices(len(points), 1)
    forward, reverse = values[:, rows, columns], values[:, columns, rows]
    noise = variance[:, rows, columns] + variance[:, columns, rows]
    gap = np.abs(forward - reverse) ** 2
    power, mean = (np.abs(reverse) ** 2).sum(axis=0), (np.abs((forward + reverse) / 2) ** 2).sum(axis=0)
    misfit, lines = _misfit(gap, noise)
    with np.errstate(divide="ignore"):  # 1/0 lines is beyond any misfit
        limit = 1 + RECIPROCITY.misfit_deviations * np.sqrt(1 / lines)
    return Reciprocity(
        pairs=tuple(pairs),
        scale=(reverse.conj() * forward).sum(axis=0) / np.where(power > 0, power, 1.0),
        difference=np.sqrt(gap.sum(axis=0) / np.where(mean > 0, mean, 1.0)),
        misfit=misfit,
        differs=misfit > limit,
        note=_note(frf, len(points)),
    )


@dataclass(frozen=True, eq=False)
class ModalReciprocity:
    """Comparison of modes of two tests that exchange drive point and response; every array (n_pairs,)."""

    pairs: tuple[tuple[int, int], ...]
    """Indices of the modes of the first and of the second test, from 0."""
    ratio: ComplexArray
    """A_lk of the first test over A_kl of the second: 1 if reciprocal."""
    ratio_error: FloatArray
    """Standard error of the real and of the imaginary part; NaN where the constants have none."""
    differs: BoolArray
    """True where the ratio differs from 1 by more than its standard error explains."""


def modal_reciprocity(first: ModalModel, second: ModalModel) -> ModalReciprocity:
    """Return the comparison of modal constants of two tests that exchange force and response.

    The first test drives at k and measures at l, the second drives at l and measures at k: `A_r,lk = phi_rl
    phi_rk = A_r,kl`, whatever the residuals are, and without a drive-point response in either test. Modes are
    paired if each is the other's nearest in frequency and their bandwidths overlap.

    Raises
    ------
    InvalidInputError
        If either test has no modal constants, or none at the other's drive point.
    """
    forward, forward_error = _constant(first, second.drive, "first")
    reverse, reverse_error = _constant(second, first.drive, "second")
    pairs = _nearest(first, second)
    a, b = [i for i, _ in pairs], [j for _, j in pairs]
    nonzero = np.abs(reverse[b]) > 0
    safe = np.where(nonzero, reverse[b], 1.0)
    ratio = np.where(nonzero, forward[a] / safe, np.inf)
    error = np.hypot(forward_error[a], np.abs(forward[a] / safe) * reverse_error[b]) / np.abs(safe)
    return ModalReciprocity(
        pairs=pairs,
        ratio=ratio,
        ratio_error=error,
        differs=np.abs(ratio - 1)
        > RECIPROCITY.mode_standard_errors * np.sqrt(2) * error,  # of a complex number
    )


def _variance(frf: FrfSet, coherence: FloatArray | None, averages: float | None) -> FloatArray:
    """Return E|error|^2 of every FRF, infinite where it is unknown."""
    if coherence is None:
        return np.full(frf.values.shape, np.inf)
    if coherence.shape != frf.values.shape:
        raise InvalidInputError(
            "coherence does not fit the FRFs",
            field="coherence",
            value=str(coherence.shape),
            allowed=str(frf.values.shape),
        )
    if averages is None or not averages > 0:
        raise InvalidInputError(
            "coherence tells random errors with the number of averages only",
            field="averages",
            value=str(averages),
            allowed=bounds(exclusive_minimum=0),
        )
    return line_variance(frf.values, coherence, averages)


def _misfit(gap: FloatArray, noise: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the mean normalised squared difference, and its number of lines, each (n_pairs,)."""
    has_variance = np.isfinite(noise) & (noise > 0)
    lines = has_variance.sum(axis=0).astype(float)
    total = np.where(has_variance, gap / np.where(has_variance, noise, 1.0), 0.0).sum(axis=0)
    return np.where(lines > 0, total / np.maximum(lines, 1.0), np.nan), lines


def _note(frf: FrfSet, n_common: int) -> str:
    if n_common > 1:
        return f"{n_common} points were both driven and heard: {n_common * (n_common - 1) // 2} pairs"
    missing = "drive" if len(frf.inputs) == 1 else "listen"
    return (
        f"no pair: {n_common or 'none'} of the points was both driven and heard, two are needed; "
        f"{missing} at a second of them"
    )


def _constant(model: ModalModel, drive: Dof | None, ordinal: str) -> tuple[ComplexArray, FloatArray]:
    """Return modal constants and errors at the other test's drive point, both in positive direction."""
    row = next(
        (i for i, dof in enumerate(model.dofs) if drive is not None and dof.point == drive.point), None
    )
    if model.drive is None or model.modal_constant is None or row is None:
        raise InvalidInputError(
            f"the {ordinal} test has no modal constants at the drive point of the other",
            field="drive",
            value=None if drive is None else str(drive),
            allowed=[str(dof) for dof in model.dofs[:5]],
        )
    error = model.modal_constant_error
    sense = model.dofs[row].sign * model.drive.sign
    unknown = np.full(len(model.modes), np.nan)
    return sense * model.modal_constant[:, row], unknown if error is None else error[:, row]


def _nearest(first: ModalModel, second: ModalModel) -> tuple[tuple[int, int], ...]:
    """Return the pairs of modes that are nearest to each other and overlap."""
    if not first.modes or not second.modes:
        return ()
    distance = np.abs(first.frequencies[:, None] - second.frequencies)
    width = [model.loss_factors * model.frequencies for model in (first, second)]
    nearest_second, nearest_first = distance.argmin(axis=1), distance.argmin(axis=0)
    return tuple(
        (i, int(j))
        for i, j in enumerate(nearest_second)
        if nearest_first[j] == i and distance[i, j] <= (width[0][i] + width[1][j]) / 2
    )
