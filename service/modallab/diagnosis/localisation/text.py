"""Where a gap sits, in plain words."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.diagnosis.residuals.residual import Residual
from modallab.diagnosis.result import ChannelError, GapPattern, Localisation, ModeShift, ResponseMisfit

NAMES = {"frf": "FRFs", "force": "force spectra", "response": "response spectra"}
CLEAR = 4.0  # standard errors from which on a shift is told
NOTABLE = 1e-5  # smaller shifts than that are not told: nobody can do anything about them
LIKE = 0.1  # spread of the shifts of all modes over their mean below which they are one
NEARLY_ALL = 0.95  # share of what is above 1 that lies where "only" is said
MOST = 8
# One response alone cannot say that the modes of a structure are elsewhere, nor can FRFs that agree.
NOT_THE_MODES = {
    GapPattern.FORCE_ONLY,
    GapPattern.COHERENCE_ONLY,
    GapPattern.ONE_RESPONSE,
    GapPattern.DRIVE_POINT_ONLY,
}
SIGNS = {
    GapPattern.FORCE_ONLY: (
        "the FRFs agree; only the auto spectra do not, most of all those of the force: look at what drives "
        "the structure"
    ),
    GapPattern.COHERENCE_ONLY: (
        "the FRFs agree; only the auto spectra do not: {more} of the responses has nothing to do with the "
        "force than the log book accounts for"
    ),
    GapPattern.ONE_RESPONSE: "one response stands out, {dof}: all others agree",
    GapPattern.DRIVE_POINT_ONLY: "the drive point, {dof}, stands out: all other responses agree",
    GapPattern.LOW_FREQUENCY: "only the low end of the band disagrees, up to {high:.4g} Hz",
    GapPattern.HIGH_FREQUENCY: "only the high end of the band disagrees, from {low:.4g} Hz",
    GapPattern.LEVEL_DEPENDENCE: (
        "the FRFs change with the force level, by {level:.1f} random errors: something is not linear"
    ),
}


@dataclass(frozen=True, eq=False)
class LocalisationText:
    """Where the part sits that carries the gap."""

    freq: FloatArray  # (n_freq,) Hz
    outputs: tuple[Dof, ...]
    by_line: FloatArray  # (n_freq,) mean squared residual
    by_channel: FloatArray  # (n_out,)
    left: Residual


def span(freq: FloatArray, by_line: FloatArray) -> tuple[float, float]:
    """Return from where to where nearly all of the gap lies, Hz."""
    excess = np.maximum(by_line - 1, 0.0)
    share = np.cumsum(excess) / max(float(excess.sum()), 1e-300)
    edge = (1 - NEARLY_ALL) / 2
    low = int(np.searchsorted(share, edge))
    return float(freq[low]), float(freq[min(int(np.searchsorted(share, 1 - edge)), len(freq) - 1)])


def said(found: Localisation, gaps: Mapping[str, float], seen: LocalisationText) -> Localisation:
    """Return what was located with its words."""
    words = [f"mean squared residual: {', '.join(f'{NAMES[part]} {gap:.3g}' for part, gap in gaps.items())}"]
    words += [_sign(sign, found, seen) for sign in found.signs]
    if not NOT_THE_MODES & set(found.signs):
        words += _shifts("natural frequencies", found.mode_shifts, "frequency")
        words += _shifts("loss factors", found.mode_shifts, "loss_factor")
    words += _responses(found)
    if found.bands:
        words.append("bands: " + ", ".join(f"{lo:.4g} to {hi:.4g} Hz" for lo, hi in found.bands[:MOST]))
    if found.dofs and len(found.dofs) < len(seen.outputs):
        words.append("responses: " + ", ".join(map(str, found.dofs)))
    return replace(found, words=tuple(words))


def _sign(sign: GapPattern, found: Localisation, seen: LocalisationText) -> str:
    low, high = span(seen.freq, seen.by_line)
    return SIGNS[sign].format(
        dof=seen.outputs[int(seen.by_channel.argmax())],
        more="more" if seen.left.response is None or seen.left.response.sum() > 0 else "less",
        low=low,
        high=high,
        level=math.sqrt(found.level_dependence or 0.0),
    )


def _shifts(what: str, shifts: tuple[ModeShift, ...], name: str) -> list[str]:
    """Return one sentence on what modes have in common, or each mode's own shift; none if none is clear."""
    each = [(one.mode, getattr(one, f"{name}_shift"), getattr(one, f"{name}_error")) for one in shifts]
    clear = [one for one in each if abs(one[1]) > max(CLEAR * one[2], NOTABLE)]
    if not clear:
        return []
    values = np.array([shift for _, shift, _ in clear])
    way = {"frequency": ("higher", "lower"), "loss_factor": ("more damped", "less damped")}[name]
    mean, size = float(values.mean()), np.abs(values)
    if len(clear) > 2 and (values * mean > 0).all():
        if size.max() - size.min() < LIKE * abs(mean):
            return [f"modes are {way[mean < 0]} than the model's, all by about {_percent(abs(mean))}"]
        for order, end in ((-1, "lower"), (1, "higher")):
            if (order * np.diff(size) > 0).all():
                first, last = _signed(values[0]), _signed(values[-1])
                return [
                    f"modes are {way[mean < 0]} than the model's, the more the {end} they are: "
                    f"mode {clear[0][0]} {first} to mode {clear[-1][0]} {last}"
                ]
    modes = ", ".join(f"mode {mode} {_signed(shift)}" for mode, shift, _ in clear[:MOST])
    return [f"{what} against the model's: {modes}"]


def _signed(share: float) -> str:
    return f"{'+' if share > 0 else '−'}{_percent(abs(share))}"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.1 else f"{100 * share:.0f} %"


def _responses(found: Localisation) -> list[str]:
    """Return what accounts for single responses, one sentence a kind of reason."""
    told = []
    for course in ChannelError:
        those = [one for one in found.responses if one.course is course]
        # Where all responses are off alike it is the force, or the model.
        if those and len(those) <= max(1, len(found.responses) // 2):
            told += [_response(one) for one in those[:MOST]]
    return told


def _response(one: ResponseMisfit) -> str:
    off = one.amplitude - 1
    if one.course is ChannelError.GAIN:
        return (
            f"{one.dof} reads {_percent(abs(off))} {'high' if off > 0 else 'low'} at all frequencies: a gain"
        )
    if one.course is ChannelError.POLARITY:
        return f"{one.dof} has the opposite sign at all frequencies"
    if one.course is ChannelError.DELAY:
        way = "lags behind" if one.delay > 0 else "is ahead"
        return f"{one.dof} {way}, the more the higher the frequency: by {_time(abs(one.delay))}"
    return f"{one.dof} reads more wrongly with the square of the frequency: as a sensor near its resonance"


def _time(seconds: float) -> str:
    return f"{seconds * 1e6:.3g} µs" if seconds < 1e-3 else f"{seconds * 1e3:.3g} ms"
