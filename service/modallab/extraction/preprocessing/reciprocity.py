"""Whether force and response may change places, as on every linear structure that does not rotate.

What the data allow: two FRFs between the same two points, measured both ways, are compared line by line
(`reciprocity`). A roving hammer with several accelerometers has such pairs among the points where both an
accelerometer sits and the hammer struck. Two tests from different drive points, each with the other's
drive point among its responses, have one pair, compared mode by mode too (`modal_reciprocity`). One drive
point and its responses, or one response and a roving hammer, have none.
"""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.common_dofs import common_points, rows_at
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.preprocessing.fit_windows import line_variance

CHANCE = 5.0  # standard deviations of a mean square; lines of one test are not wholly independent
CLEAR = 3.0  # standard errors


@dataclass(frozen=True, eq=False)
class Reciprocity:
    """Pairs of FRFs between the same points; every array (n_pairs,)."""

    pairs: tuple[tuple[Dof, Dof], ...]  # (j, k): H_jk, response at j, against H_kj
    scale: ComplexArray  # H_jk = scale H_kj as near as can be; 1 if reciprocal, -1 if a sign is wrong
    difference: FloatArray  # rms of H_jk - H_kj over that of their mean
    misfit: FloatArray  # mean of |H_jk - H_kj|^2 over its variance, 1 if random; NaN where it is not known
    differs: BoolArray  # beyond random error
    note: str  # what the data allow


def reciprocity(
    frf: FrfSet, *, coherence: FloatArray | None = None, averages: float | None = None
) -> Reciprocity:
    """Return how far every two FRFs between the same points differ.

    Sums are over the lines above 0 Hz, of the FRFs as they are: inertance weighs high frequencies, receptance
    low ones. The two are taken to have errors of their own; noise of a force gauge that both share makes
    them differ by less.

    Parameters
    ----------
    frf
        Any number of outputs and inputs, of any kind.
    coherence
        (n_freq, n_out, n_in), of each FRF; None where it is not known.
    averages
        Effective number of averages behind the coherence.

    Raises
    ------
    InvalidInputError
        If the coherence does not fit the FRFs, or comes without averages.
    """
    points = common_points(frf.outputs, frf.inputs)
    both = [(a, b) for n, a in enumerate(points) for b in points[n + 1 :]]
    above = frf.freq > 0
    variance = _variance(frf, coherence, averages)[above]
    out, signs_out = rows_at(frf.outputs, points)
    into, signs_in = rows_at(frf.inputs, points)
    turned = frf.values[above][:, out][:, :, into] * np.outer(signs_out, signs_in)
    variance = variance[:, out][:, :, into]
    one, other = np.triu_indices(len(points), 1)
    there, back = turned[:, one, other], turned[:, other, one]
    noise = variance[:, one, other] + variance[:, other, one]
    gap = np.abs(there - back) ** 2
    power, mean = (np.abs(back) ** 2).sum(axis=0), (np.abs((there + back) / 2) ** 2).sum(axis=0)
    misfit, lines = _misfit(gap, noise)
    with np.errstate(divide="ignore"):  # 1/0 lines is beyond any misfit
        limit = 1 + CHANCE * np.sqrt(1 / lines)
    return Reciprocity(
        pairs=tuple(both),
        scale=(back.conj() * there).sum(axis=0) / np.where(power > 0, power, 1.0),
        difference=np.sqrt(gap.sum(axis=0) / np.where(mean > 0, mean, 1.0)),
        misfit=misfit,
        differs=misfit > limit,
        note=_note(frf, len(points)),
    )


@dataclass(frozen=True, eq=False)
class ModalReciprocity:
    """Modes of two tests that drive at each other's response; every array (n_pairs,)."""

    pairs: tuple[tuple[int, int], ...]  # modes of the first test and of the second, counted from 0
    ratio: ComplexArray  # A_lk of the first over A_kl of the second; 1 if reciprocal
    ratio_error: FloatArray  # standard error of either part; NaN where the constants have none
    differs: BoolArray  # beyond its standard error


def modal_reciprocity(first: ModalModel, second: ModalModel) -> ModalReciprocity:
    """Return how far modal constants of two tests agree when force and response change places.

    The first drives at k and hears l, the second drives at l and hears k: `A_r,lk = phi_rl phi_rk = A_r,kl`,
    whatever lies beside the modes, and without a drive-point response in either. Modes pair whose frequencies
    are nearest to one another and within their half-power bandwidths.

    Raises
    ------
    InvalidInputError
        If either lacks modal constants or the other's drive point.
    """
    there, there_error = _constant(first, second.drive, "first")
    back, back_error = _constant(second, first.drive, "second")
    pairs = _nearest(first, second)
    a, b = [i for i, _ in pairs], [j for _, j in pairs]
    known = np.abs(back[b]) > 0
    safe = np.where(known, back[b], 1.0)
    ratio = np.where(known, there[a] / safe, np.inf)
    error = np.hypot(there_error[a], np.abs(there[a] / safe) * back_error[b]) / np.abs(safe)
    return ModalReciprocity(
        pairs=pairs,
        ratio=ratio,
        ratio_error=error,
        differs=np.abs(ratio - 1) > CLEAR * np.sqrt(2) * error,  # error is that of either part
    )


def _variance(frf: FrfSet, coherence: FloatArray | None, averages: float | None) -> FloatArray:
    """Return E|error|^2 of every FRF, infinite where nothing is known of it."""
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
            allowed="> 0",
        )
    return line_variance(frf.values, coherence, averages)


def _misfit(gap: FloatArray, noise: FloatArray) -> tuple[FloatArray, FloatArray]:
    known = np.isfinite(noise) & (noise > 0)
    lines = known.sum(axis=0).astype(float)
    total = np.where(known, gap / np.where(known, noise, 1.0), 0.0).sum(axis=0)
    return np.where(lines > 0, total / np.maximum(lines, 1.0), np.nan), lines


def _note(frf: FrfSet, n_shared: int) -> str:
    if n_shared > 1:
        return f"{n_shared} points were both driven and heard: {n_shared * (n_shared - 1) // 2} pairs"
    missing = "drive" if len(frf.inputs) == 1 else "listen"
    return (
        f"no pair: {n_shared or 'none'} of the points was both driven and heard, two are needed; "
        f"{missing} at a second of them"
    )


def _constant(model: ModalModel, at: Dof | None, which: str) -> tuple[ComplexArray, FloatArray]:
    """Return modal constants and errors at the other test's drive point, in the positive sense of both."""
    row = next((i for i, dof in enumerate(model.dofs) if at is not None and dof.point == at.point), None)
    if model.drive is None or model.modal_constant is None or row is None:
        raise InvalidInputError(
            f"the {which} test has no modal constants at the drive point of the other",
            field="drive",
            value="none" if at is None else str(at),
            allowed=", ".join(str(dof) for dof in model.dofs[:5]),
        )
    error = model.modal_constant_error
    sense = model.dofs[row].sign * model.drive.sign
    unknown = np.full(len(model.modes), np.nan)
    return sense * model.modal_constant[:, row], unknown if error is None else error[:, row]


def _nearest(first: ModalModel, second: ModalModel) -> tuple[tuple[int, int], ...]:
    """Return modes that are each other's nearest and overlap."""
    if not first.modes or not second.modes:
        return ()
    apart = np.abs(first.frequencies[:, None] - second.frequencies)
    width = [model.loss_factors * model.frequencies for model in (first, second)]
    near, back = apart.argmin(axis=1), apart.argmin(axis=0)
    return tuple(
        (i, int(j))
        for i, j in enumerate(near)
        if back[j] == i and apart[i, j] <= (width[0][i] + width[1][j]) / 2
    )
