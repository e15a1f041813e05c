"""Where the model without additions parts from the measurement: lines, responses, modes, and what tells."""

from collections.abc import Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.correlation.evidence import Evidence
from modallab.diagnosis.localisation import text as located_words
from modallab.diagnosis.localisation.mode_shifts import mode_shifts
from modallab.diagnosis.localisation.response_misfits import response_misfits
from modallab.diagnosis.localisation.text import LocalisationText, span
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.residual import scatters
from modallab.diagnosis.result import GapPattern, Localisation

DISAGREES = 3.0  # mean squared residual above which a band or a response is named
BEYOND = 5.0  # standard errors by which a part's gap is above 1 if it disagrees
END = 0.25  # share of the band that is its low or its high end
LOUDER = 0.1  # of another part's excess: where that of the FRFs is less, they are not where the gap sits
OTHERS = 0.05  # share of the worst response's excess below which another one agrees beside it
MOST_BANDS = 20
MOST_MODES = 8  # whose shifts are worked out: each takes predictions of its own


def locate(predictor: Predictor, evidence: Evidence) -> Localisation:
    """Return where the gap sits: bands, responses, modes, in numbers and in words.

    Parameters
    ----------
    predictor
        Of one test or of several; all but the dependence on the level is told of the first.
    evidence
        What the first test and its prediction without additions disagree in.
    """
    first = predictor.tests[0]
    predicted, left = first.predict(()), first.residual(())
    usable = first.observed.usable
    gaps, errors = left.gaps(usable), scatters(first.observed, left, usable)
    parts = {part for part, gap in gaps.items() if gap > 1 + BEYOND * errors[part]}
    level = _level_dependence(predictor)
    carrier = _carrier(gaps, parts)
    # Where FRFs agree it is told where the part sits that does not.
    squares = _squares(left.rescaled[carrier], usable)
    by_line, by_channel = (_mean(squares, usable, axis) for axis in (1, 0))
    bands = _bands(first.observed.freq, by_line)
    shown = range(1, min(MOST_MODES, len(evidence.mode_frequency)) + 1) if "frf" in parts else ()
    found = Localisation(
        bands=bands[:MOST_BANDS],
        dofs=_dofs(evidence.outputs, by_channel),
        modes=_modes(evidence, bands),
        signs=tuple(_signs(carrier if parts else None, first, by_line, by_channel, level)),
        mode_shifts=mode_shifts(
            first, predicted.h, shown, [float(evidence.frequency_shift[m - 1]) for m in shown]
        ),
        responses=response_misfits(first.observed, predicted.h),
        level_dependence=level,
    )
    return located_words.said(
        found, gaps, LocalisationText(first.observed.freq, evidence.outputs, by_line, by_channel, left)
    )


def _carrier(gaps: Mapping[str, float], parts: AbstractSet[str]) -> str:
    """Return the part that carries the gap: the FRFs, unless they nearly agree and another does not."""
    loud = {part: gaps[part] - 1 for part in parts}
    worst = max(loud, key=lambda part: loud[part], default="frf")
    quiet = gaps["frf"] < DISAGREES and loud.get("frf", 0.0) < LOUDER * loud.get(worst, 0.0)
    return worst if quiet else "frf"


def _squares(part: ComplexArray | FloatArray, usable: BoolArray) -> FloatArray:
    return np.broadcast_to(np.abs(part) ** 2, usable.shape) * usable


def _mean(squares: FloatArray, usable: BoolArray, axis: int) -> FloatArray:
    return np.asarray(squares.sum(axis=axis) / np.maximum(usable.sum(axis=axis), 1))


def _bands(freq: FloatArray, by_line: FloatArray) -> tuple[tuple[float, float], ...]:
    line = np.convolve(by_line, np.ones(3) / 3, mode="same")
    typical = max(DISAGREES, 0.1 * float(line.max(initial=0.0)))
    high = np.flatnonzero(line > typical)
    groups = np.split(high, np.flatnonzero(np.diff(high) > 3) + 1) if high.size else []
    return tuple((float(freq[g[0]]), float(freq[g[-1]])) for g in groups)


def _dofs(outputs: Sequence[Dof], by_channel: FloatArray) -> tuple[Dof, ...]:
    worst = max(DISAGREES, 0.5 * float(by_channel.max(initial=0.0)))
    return tuple(d for d, gap in zip(outputs, by_channel, strict=True) if gap > worst)


def _modes(evidence: Evidence, bands: tuple[tuple[float, float], ...]) -> tuple[int, ...]:
    spacing = float(evidence.freq[1] - evidence.freq[0])
    return tuple(
        i + 1
        for i, f in enumerate(evidence.mode_frequency)
        if any(lo - 2 * spacing <= f <= hi + 2 * spacing for lo, hi in bands)
    )


def _signs(
    carrier: str | None, first: Predictor, by_line: FloatArray, by_channel: FloatArray, level: float | None
) -> Iterator[GapPattern]:
    """Yield what is telling.

    Parameters
    ----------
    carrier
        The part that the gap is in; None if all agree.
    """
    if carrier == "force":
        yield GapPattern.FORCE_ONLY
    if carrier == "response":
        yield GapPattern.COHERENCE_ONLY
    if carrier in ("frf", "response") and _alone(by_channel):
        at_drive = first.observed.outputs[int(by_channel.argmax())].point == first.setup.drive.point
        yield GapPattern.DRIVE_POINT_ONLY if at_drive else GapPattern.ONE_RESPONSE
    if carrier is not None and by_line.max() > DISAGREES:
        low, high = span(first.observed.freq, by_line)
        if high < END * first.observed.freq[-1]:
            yield GapPattern.LOW_FREQUENCY
        if low > (1 - END) * first.observed.freq[-1]:
            yield GapPattern.HIGH_FREQUENCY
    if level is not None and level > DISAGREES:
        yield GapPattern.LEVEL_DEPENDENCE


def _alone(by_channel: FloatArray) -> bool:
    """Return whether one response disagrees and at least two others agree."""
    order = np.sort(by_channel)
    return len(order) > 2 and order[-1] > DISAGREES and order[-2] - 1 < OTHERS * (order[-1] - 1)


def _level_dependence(predictor: Predictor) -> float | None:
    """Return the mean squared difference of the FRFs of tests at other levels over its random variance."""
    first, *others = predictor.tests
    gaps = []
    for other in others:
        seen, own = other.observed, first.observed
        level = other.setup.analyser.excitation.level / first.setup.analyser.excitation.level
        same = seen.outputs == own.outputs and other.setup.drives == first.setup.drives
        if level == 1 or not same or not np.array_equal(seen.freq, own.freq):
            continue
        both = seen.usable & own.usable
        variance = 2 * (seen.error[both] ** 2 + own.error[both] ** 2)
        gaps.append(float((np.abs(np.log(seen.h[both] / own.h[both])) ** 2 / variance).mean()))
    return max(gaps) if gaps else None
