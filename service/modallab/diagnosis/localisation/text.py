"""Statements in plain English on where measurement and prediction differ."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.diagnosis.localisation.settings import STATEMENTS
from modallab.diagnosis.residuals.residual import Residual
from modallab.diagnosis.result_localisation import (
    ChannelError,
    GapPattern,
    Localisation,
    ModeShift,
    ResponseMisfit,
)
from modallab.rig.frf_channel import FrfChannel, stands_for_response

PARTS = {"frf": "FRFs", "force": "force spectra", "response": "response spectra"}
# With these patterns the disagreement does not come from the modes of the structure.
PATTERNS_WITHOUT_MODES = {
    GapPattern.FORCE_ONLY,
    GapPattern.COHERENCE_ONLY,
    GapPattern.ONE_RESPONSE,
    GapPattern.DRIVE_POINT_ONLY,
}
OTHERS_AGREE = "all others agree within random error and tolerances"
PATTERNS = {
    GapPattern.FORCE_ONLY: (
        "the FRFs agree; only the auto spectra disagree, the force spectrum most: "
        "the cause lies in the excitation of the structure"
    ),
    GapPattern.COHERENCE_ONLY: (
        "the FRFs agree; only the auto spectra disagree: the part of the responses that is not coherent "
        "with the force is {size} than the log book predicts"
    ),
    GapPattern.ONE_RESPONSE: "only one response, {dof}, disagrees; {others_agree}",
    GapPattern.DRIVE_POINT_ONLY: "only the drive point, {dof}, disagrees; {others_agree}",
    GapPattern.LOW_FREQUENCY: "only the low end of the band disagrees, up to {high:.4g} Hz",
    GapPattern.HIGH_FREQUENCY: "only the high end of the band disagrees, from {low:.4g} Hz",
    GapPattern.LEVEL_DEPENDENCE: (
        "the FRFs depend on the force level, by {level:.1f} random errors: structure or rig is nonlinear"
    ),
}
# With a roving hammer a response has several FRFs.
FRF_PATTERNS = {
    GapPattern.ONE_RESPONSE: "only one FRF, {frf}, disagrees; {others_agree}",
    GapPattern.DRIVE_POINT_ONLY: "only the drive-point FRF {frf} disagrees; {others_agree}",
}


@dataclass(frozen=True, eq=False)
class GapDistribution:
    """Distribution of the gap over frequency and FRFs, of the part that carries it."""

    freq: FloatArray
    """Hz, (n_freq,), frequency lines."""
    channels: tuple[FrfChannel, ...]
    """Measured FRFs."""
    by_line: FloatArray
    """(n_freq,), mean squared residual of each line."""
    by_channel: FloatArray
    """(n_out,), mean squared residual of each FRF, or of all FRFs of its response to simultaneous forces."""
    residual: Residual
    """Residual of the prediction without added effects."""

    @property
    def several_forces(self) -> bool:
        """Whether forces acted at several points."""
        return len({channel.drive for channel in self.channels}) > 1

    @property
    def roving_hammer(self) -> bool:
        """Whether forces acted at several points one after the other."""
        return self.several_forces and bool(stands_for_response(self.channels).all())


def span(freq: FloatArray, by_line: FloatArray) -> tuple[float, float]:
    """Return the lower and upper limit, Hz, of the band that holds nearly all of the gap."""
    excess = np.maximum(by_line - 1, 0.0)
    share = np.cumsum(excess) / max(float(excess.sum()), SAFE_DIVISOR)
    tail = (1 - STATEMENTS.band_share) / 2
    low, high = int(np.searchsorted(share, tail)), int(np.searchsorted(share, 1 - tail))
    return float(freq[low]), float(freq[min(high, len(freq) - 1)])


def with_statements(
    localisation: Localisation, gaps: Mapping[str, float], distribution: GapDistribution
) -> Localisation:
    """Return the localisation with its statements in plain English."""
    parts = ", ".join(f"{PARTS[part]} {gap:.3g}" for part, gap in gaps.items())
    words = [f"mean squared residual: {parts}"]
    words += [_pattern(pattern, localisation, distribution) for pattern in localisation.signs]
    if not PATTERNS_WITHOUT_MODES & set(localisation.signs):
        words += _mode_shifts("natural frequencies", localisation.mode_shifts, "frequency")
        words += _mode_shifts("loss factors", localisation.mode_shifts, "loss_factor")
    words += _channel_errors(localisation)
    if localisation.bands:
        bands = localisation.bands[: STATEMENTS.max_items]
        words.append("bands: " + ", ".join(f"{low:.4g} to {high:.4g} Hz" for low, high in bands))
    if localisation.dofs and len(localisation.dofs) < len(distribution.channels):
        dofs = ", ".join(map(str, localisation.dofs))
        words.append(f"{'points' if distribution.several_forces else 'responses'}: {dofs}")
    return replace(localisation, words=tuple(words))


def _pattern(pattern: GapPattern, localisation: Localisation, distribution: GapDistribution) -> str:
    low, high = span(distribution.freq, distribution.by_line)
    response = distribution.residual.response
    worst = distribution.channels[int(distribution.by_channel.argmax())]
    patterns = {**PATTERNS, **(FRF_PATTERNS if distribution.roving_hammer else {})}
    return patterns[pattern].format(
        others_agree=OTHERS_AGREE,
        dof=worst.response,
        frf=worst,
        size="larger" if response is None or response.sum() > 0 else "smaller",
        low=low,
        high=high,
        level=math.sqrt(localisation.level_dependence or 0.0),
    )


def _mode_shifts(quantity: str, shifts: tuple[ModeShift, ...], name: str) -> list[str]:
    """Return a statement on the significant shifts: a common trend, or each mode; empty if none is.

    Parameters
    ----------
    quantity
        Name of the shifted quantity, plural.
    name
        Start of the names of its fields in `ModeShift`.
    """
    values = [(s.mode, getattr(s, f"{name}_shift"), getattr(s, f"{name}_error")) for s in shifts]
    limit = STATEMENTS.shift_significance
    significant = [
        (mode, shift)
        for mode, shift, error in values
        if abs(shift) > max(limit * error, STATEMENTS.smallest_shift)
    ]
    if not significant:
        return []
    if trend := _trend(significant):
        return [f"the {quantity} are {trend}"]
    modes = ", ".join(f"mode {mode} {_signed(shift)}" for mode, shift in significant[: STATEMENTS.max_items])
    return [f"the {quantity} differ from the model's: {modes}"]


def _trend(shifts: list[tuple[int, float]]) -> str:
    """Return the common trend of shifts (mode, relative shift); empty if there is none."""
    values = np.array([shift for _, shift in shifts])
    mean, size = float(values.mean()), np.abs(values)
    if len(shifts) <= 2 or not (values * mean > 0).all():  # 2: any two shifts have a trend
        return ""
    direction = "lower" if mean < 0 else "higher"
    if size.max() - size.min() < STATEMENTS.common_spread * abs(mean):
        return f"{direction} than the model's, all by about {_percent(abs(mean))}"
    for order, end in ((-1, "lower"), (1, "higher")):
        if (order * np.diff(size) > 0).all():
            (first, first_shift), (last, last_shift) = shifts[0], shifts[-1]
            return (
                f"{direction} than the model's, and the shift grows towards {end} modes: "
                f"mode {first} {_signed(first_shift)} to mode {last} {_signed(last_shift)}"
            )
    return ""


def _signed(share: float) -> str:
    return f"{'+' if share > 0 else '−'}{_percent(abs(share))}"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.1 else f"{100 * share:.0f} %"  # 0.1: two digits in either form


def _channel_errors(localisation: Localisation) -> list[str]:
    """Return a statement on each FRF with a channel error, by kind of error.

    An error that most FRFs share is omitted: the force or the model causes it, not the channels.
    """
    statements = []
    for error in ChannelError:
        misfits = [misfit for misfit in localisation.responses if misfit.course is error]
        if misfits and len(misfits) <= max(1, len(localisation.responses) // 2):
            several_forces = len({misfit.drive for misfit in localisation.responses}) > 1
            statements += [
                _channel_error(
                    misfit, f"{misfit.dof} / {misfit.drive}" if several_forces else str(misfit.dof)
                )
                for misfit in misfits[: STATEMENTS.max_items]
            ]
    return statements


def _channel_error(misfit: ResponseMisfit, name: str) -> str:
    deviation = misfit.amplitude - 1
    if misfit.course is ChannelError.GAIN:
        direction = "high" if deviation > 0 else "low"
        size = f"{_percent(abs(deviation))} {direction}"
        return f"{name} reads {size} at all frequencies, as with a gain error"
    if misfit.course is ChannelError.POLARITY:
        return f"{name} has the opposite sign at all frequencies"
    if misfit.course is ChannelError.DELAY:
        verb = "lags" if misfit.delay > 0 else "leads"
        return f"{name} {verb} by {_time(abs(misfit.delay))}, its phase error proportional to frequency"
    return (
        f"{name} deviates in amplitude with the square of frequency, as a sensor does near its mounted "
        "resonance"
    )


def _time(seconds: float) -> str:
    return f"{seconds * 1e6:.3g} µs" if seconds < 1e-3 else f"{seconds * 1e3:.3g} ms"
