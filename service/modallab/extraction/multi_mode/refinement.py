"""Poles made into modes: all fitted together, those that are none left out, what lies beyond allowed for."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.progress import Progress, part
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.modal_fit import fit_modes, fitted_receptance
from modallab.extraction.multi_mode.mode_selection import NEAR
from modallab.extraction.multi_mode.variable_projection import disturbed
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.line_noise import weights_from_residuals

SEEN = 5.0  # standard errors: noise alone shows a modal constant so large once in 300,000 FRFs
SURE = 0.5  # of a bandwidth or a line: a mode less surely placed may be none
ROUNDS = 12  # of leaving out modes that prove to be none
LATER = 0.4  # of the time that is left is for rounds after the next: the first takes longest
REWEIGHTED = 2  # times, where only residuals tell the random error
ABOVE, BELOW = 1.2, 0.8  # of the ends of the range, where a mode beyond is looked for first
BEYOND_DAMPING = 0.01


@dataclass(frozen=True, eq=False)
class BandData:
    """Lines of a range, and all that is known of them."""

    freq: FloatArray  # (n_lines,) Hz
    receptance: ComplexArray  # (n_lines, n_frf) m/N
    weight: FloatArray  # (n_lines, n_frf) one over E|error|^2
    known: bool  # whether the weights are the random error; else a shape that they may have
    n_ref: int = 1  # references, of which each DoF has an FRF


@dataclass(frozen=True, eq=False)
class StartingPoles:
    """Modes as a pole finder has them."""

    eigenvalue: ComplexArray  # (n_modes,) omega_r^2 (1 + i eta_r), (rad/s)^2
    participation: ComplexArray | None  # (n_modes, n_ref); None where FRFs are to be fitted each by itself


@dataclass(frozen=True, eq=False)
class RefinedModes:
    """All modes of a stretch fitted."""

    fit: ModalFit
    weight: FloatArray  # (n_lines, n_frf) that the fit ended with
    left_out: tuple[str, ...]  # in words
    # (n_modes, 2) by what frequency, Hz, and loss factor may be off for leakage still; None without
    leakage_bias: FloatArray | None = None


def refine(
    stretch: BandData, start: StartingPoles, damping: Damping, progress: Progress
) -> RefinedModes | None:
    """Return the fit of all modes that are seen; None if there is none.

    Parameters
    ----------
    start
        From a pole finder.
    damping
        Law of the modes.
    """
    weight = stretch.weight
    left_out: list[str] = []
    start = _with_modes_beyond(start, stretch.freq)
    for n in range(ROUNDS):
        step = part(progress, 1 - LATER**n, 1 - LATER ** (n + 1))
        fit = fit_modes(
            stretch.freq,
            stretch.receptance,
            weight,
            start.eigenvalue,
            damping=damping,
            participation=start.participation,
            progress=step,
        )
        if not stretch.known and n < REWEIGHTED:
            fitted = fitted_receptance(fit, stretch.freq, damping)
            weight = weights_from_residuals(stretch.receptance, fitted, stretch.weight)
            start = StartingPoles(fit.eigenvalue, fit.participation)
            continue
        none = none_of(fit, stretch.freq)
        if not none.any():
            return RefinedModes(fit, weight, tuple(left_out))
        left_out += [f"{f:.4g} Hz: no FRF shows it beyond its random error" for f in fit.frequency[none]]
        if not (between_ends(fit, stretch.freq) & (fit.loss_factor > 0) & ~none).any():
            return None
        reach = fit.participation
        start = StartingPoles(fit.eigenvalue[~none], None if reach is None else reach[~none])
    return RefinedModes(fit, weight, tuple(left_out))


def between_ends(fit: ModalFit, freq: FloatArray) -> BoolArray:
    """Return which poles lie inside the range; one that gains energy bends it, and is no mode."""
    return np.asarray((fit.frequency >= freq[0]) & (fit.frequency <= freq[-1]))


def none_of(fit: ModalFit, freq: FloatArray) -> BoolArray:
    """Return which poles inside the range are nothing: nowhere seen, or hardly placed.

    Where two share one resonance and either might be left out, the one less seen.
    """
    spacing = float(np.median(np.diff(freq)))
    width = fit.loss_factor * fit.frequency
    shown = (np.abs(fit.modal_constant) / np.maximum(fit.modal_constant_error, 1e-300)).max(axis=1)
    if fit.clear is not None:
        shown = np.maximum(shown, fit.clear)
    sure = (fit.frequency_error < SURE * np.maximum(width, spacing)) & (
        fit.loss_factor_error < np.abs(fit.loss_factor)
    )
    none = ((shown < SEEN) | ~sure) & between_ends(fit, freq)
    near = np.abs(fit.frequency[:, None] - fit.frequency) < NEAR * np.maximum(width[:, None], width)
    surer = shown[None, :] < shown[:, None]
    return np.asarray(none & ~(near & none[None, :] & surer).any(axis=1))


def _with_modes_beyond(start: StartingPoles, freq: FloatArray) -> StartingPoles:
    """Return the eigenvalues with one beyond either end of a range that such a mode bends, and that can tell.

    A mode not far beyond is no constant over the range.
    """
    if not disturbed(freq):
        return start
    beyond = np.array([BELOW * freq[0], ABOVE * freq[-1]])
    eigenvalue = np.append(start.eigenvalue, (2 * np.pi * beyond) ** 2 * (1 + 1j * BEYOND_DAMPING))
    reach = start.participation
    if reach is not None:  # one of either sign, as nothing is known of them
        unknown = (-1.0) ** np.multiply.outer(np.arange(2), np.arange(reach.shape[1]))
        reach = np.concatenate([reach, unknown])
    return StartingPoles(eigenvalue, reach)
