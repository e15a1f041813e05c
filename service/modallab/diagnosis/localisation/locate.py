"""Localisation of the disagreement between measurement and model: bands, responses, modes, patterns."""

from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.dof import Dof
from modallab.correlation.evidence import Evidence
from modallab.diagnosis.localisation.mode_shifts import mode_shifts
from modallab.diagnosis.localisation.response_misfits import response_misfits
from modallab.diagnosis.localisation.settings import LOCALISATION
from modallab.diagnosis.localisation.text import GapDistribution, span, with_statements
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import gap_errors
from modallab.diagnosis.result_localisation import GapPattern, Localisation
from modallab.rig.frf_channel import stands_for_response


def locate(predictor: Predictor, evidence: Evidence) -> Localisation:
    """Return where measurement and prediction without added effects disagree, in numbers and statements.

    Parameters
    ----------
    predictor
        Predictor of one test or several; everything but the level dependence refers to the first.
    evidence
        Disagreement of the first test and its prediction without added effects.

    Returns
    -------
    Localisation
        Bands in Hz, responses, modes counted from 1, patterns, mode shifts, misfits of responses.
    """
    first = predictor.tests[0]
    predicted, residual = first.predict(()), first.residual(())
    usable = first.observed.usable
    gaps, errors = residual.gaps(usable), gap_errors(first.observed, residual, usable)
    parts = {part for part, gap in gaps.items() if gap > 1 + LOCALISATION.part_significance * errors[part]}
    level = _level_dependence(predictor)
    carrier = _carrier(gaps, parts)
    # Where the FRFs agree, bands and responses are those of the part that does not.
    part = residual.rescaled[carrier]
    squares = np.abs(part[:, first.observed.forces] if carrier == "force" else part) ** 2 * usable
    by_line, by_channel = _mean(squares, usable, 1), _by_record(first.observed, _mean(squares, usable, 0))
    bands = _bands(first.observed.freq, by_line)
    n_modes = min(LOCALISATION.max_modes, len(evidence.mode_frequency)) if "frf" in parts else 0
    modes = range(1, n_modes + 1)
    localisation = Localisation(
        bands=bands[: LOCALISATION.max_bands],
        dofs=_dofs(first.observed, squares),
        modes=_modes(evidence, bands),
        signs=tuple(_patterns(carrier if parts else None, first, by_line, by_channel, level)),
        mode_shifts=mode_shifts(
            first, predicted.h, modes, [float(evidence.frequency_shift[m - 1]) for m in modes]
        ),
        responses=response_misfits(first.observed, predicted.h),
        level_dependence=level,
    )
    return with_statements(
        localisation,
        gaps,
        GapDistribution(first.observed.freq, first.observed.channels, by_line, by_channel, residual),
    )


def _carrier(gaps: Mapping[str, float], parts: AbstractSet[str]) -> str:
    """Return the part that carries the gap: the FRFs, unless they nearly agree and another does not."""
    excess = {part: gaps[part] - 1 for part in parts}
    worst = max(excess, key=lambda part: excess[part], default="frf")
    threshold = LOCALISATION.minor_excess * excess.get(worst, 0.0)
    frfs_agree = gaps["frf"] < LOCALISATION.disagreement and excess.get("frf", 0.0) < threshold
    return worst if frfs_agree else "frf"


def _mean(squares: FloatArray, usable: BoolArray, axis: int) -> FloatArray:
    return np.asarray(squares.sum(axis=axis) / np.maximum(usable.sum(axis=axis), 1))


def _by_record(observed: Observed, by_channel: FloatArray) -> FloatArray:
    """Return the mean squares (n_out,) of FRFs; of those to simultaneous forces that of the response."""
    if observed.n_simultaneous == 1:
        return by_channel
    records = [(channel.run, channel.response) for channel in observed.channels]
    same = np.array([[record == other for other in records] for record in records])
    return np.asarray(same @ by_channel / same.sum(axis=1))


def _bands(freq: FloatArray, by_line: FloatArray) -> tuple[tuple[float, float], ...]:
    """Return the bands, Hz, whose smoothed mean squared residual is high."""
    n = LOCALISATION.band_separation
    smooth = np.convolve(by_line, np.ones(n) / n, mode="same")
    threshold = max(LOCALISATION.disagreement, LOCALISATION.band_level * float(smooth.max(initial=0.0)))
    high = np.flatnonzero(smooth > threshold)
    groups = np.split(high, np.flatnonzero(np.diff(high) > n) + 1) if high.size else []
    return tuple((float(freq[g[0]]), float(freq[g[-1]])) for g in groups)


def _dofs(observed: Observed, squares: FloatArray) -> tuple[Dof, ...]:
    """Return the responses, and the points of several forces, with a high mean squared residual."""
    responses, drives = (
        {dof: [dof == getattr(channel, side) for channel in observed.channels] for dof in dofs}
        for side, dofs in (
            ("response", observed.outputs),
            ("drive", [channel.drive for channel in observed.channels]),
        )
    )
    # One DoF has no other to compare with.
    sides = [side for side in (responses, drives) if len(side) > 1] or [responses]
    gaps = {
        dof: float(squares[:, at_dof].sum() / max(observed.usable[:, at_dof].sum(), 1))
        for side in sides
        for dof, at_dof in side.items()
    }
    threshold = max(LOCALISATION.disagreement, LOCALISATION.response_level * max(gaps.values()))
    return tuple(dof for dof, gap in gaps.items() if gap > threshold)


def _modes(evidence: Evidence, bands: tuple[tuple[float, float], ...]) -> tuple[int, ...]:
    """Return the modes, counted from 1, in or beside the bands."""
    margin = LOCALISATION.mode_margin * float(np.diff(evidence.freq).min())
    return tuple(
        i + 1
        for i, f in enumerate(evidence.mode_frequency)
        if any(lo - margin <= f <= hi + margin for lo, hi in bands)
    )


def _patterns(
    carrier: str | None,
    first: SingleTestPredictor,
    by_line: FloatArray,
    by_channel: FloatArray,
    level: float | None,
) -> Iterator[GapPattern]:
    """Yield the patterns of the gap.

    Parameters
    ----------
    carrier
        Part that carries the gap; None if all parts agree.
    by_line, by_channel
        (n_freq,) and (n_out,), mean squared residuals.
    level
        Level dependence; None if the tests have one level.
    """
    if carrier == "force":
        yield GapPattern.FORCE_ONLY
    if carrier == "response":
        yield GapPattern.COHERENCE_ONLY
    channels = first.observed.channels
    if carrier in ("frf", "response") and _one_disagrees(by_channel[stands_for_response(channels)]):
        worst = channels[int(by_channel.argmax())]
        record = [c for c in channels if (c.run, c.response) == (worst.run, worst.response)]
        at_drive_point = any(channel.at_drive_point for channel in record)
        yield GapPattern.DRIVE_POINT_ONLY if at_drive_point else GapPattern.ONE_RESPONSE
    if carrier is not None and by_line.max() > LOCALISATION.disagreement:
        low, high = span(first.observed.freq, by_line)
        if high < LOCALISATION.band_end * first.observed.freq[-1]:
            yield GapPattern.LOW_FREQUENCY
        if low > (1 - LOCALISATION.band_end) * first.observed.freq[-1]:
            yield GapPattern.HIGH_FREQUENCY
    if level is not None and level > LOCALISATION.disagreement:
        yield GapPattern.LEVEL_DEPENDENCE


def _one_disagrees(by_channel: FloatArray) -> bool:
    """Return whether one FRF disagrees and at least two others agree."""
    order = np.sort(by_channel)
    if len(order) <= 2 or order[-1] <= LOCALISATION.disagreement:  # 2: with fewer there is no majority
        return False
    return bool(order[-2] - 1 < LOCALISATION.agreeing_excess * (order[-1] - 1))


def _level_dependence(predictor: Predictor) -> float | None:
    """Return the mean squared difference of FRFs at two force levels over its random variance."""
    first, *further_tests = predictor.tests
    reference = first.observed
    gaps = []
    for test in further_tests:
        observed = test.observed
        level = test.setup.analyser.source_level / first.setup.analyser.source_level
        comparable = observed.channels == reference.channels
        if level == 1 or not comparable or not np.array_equal(observed.freq, reference.freq):
            continue
        usable = observed.usable & reference.usable
        variance = 2 * (observed.error[usable] ** 2 + reference.error[usable] ** 2)
        log_ratio = np.log(observed.h[usable] / reference.h[usable])
        gaps.append(float((np.abs(log_ratio) ** 2 / variance).mean()))
    return max(gaps) if gaps else None
