"""Modes of cleaned lines, with errors that know how leakage was undone, and what it may have left."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.leakage_correction import LeakageCorrection, cleaned, leaked_weights
from modallab.extraction.multi_mode.leaked_covariance import with_leaked_errors
from modallab.extraction.multi_mode.modal_fit import fit_modes, one_step
from modallab.extraction.multi_mode.refinement import BandData, RefinedModes
from modallab.extraction.options import Damping

STEP = 0.1  # standard errors by which cleaners are moved: far within what is linear
VAGUE = 0.3  # of a cleaner's own loss factor: an error beyond it does more than what is linear tells
# What cleaning may leave: of the loss factor that it takes off, and of a line in frequency. Of a free beam's
# modes 0.3 to 5 lines wide without random error it leaves up to 2 % of that, half of them less than 0.1 %,
# and up to 0.0023 lines, 0.0008 where they are wider than one; of narrower ones cleaners have more.
LEFT, LEFT_IN_FREQUENCY = 0.02, 0.002


def allowing_for_leakage(
    refined: RefinedModes, stretch: BandData, leaked: LeakageCorrection, damping: Damping
) -> RefinedModes:
    """Return the modes, their errors with those of the modes that cleaned the lines, and what may be left.

    Cleaned lines agree in part with whatever mode cleaned them: their scatter about it does not tell how
    wrong that is. So errors of the cleaners move the modes, by as much as moving a cleaner does; one too
    vague for that hands on its own error. Of leakage may be left a part of what cleaning has moved a mode by,
    from a fit of the lines as they are, and what the bias of its cleaner moves it by. A mode that none
    cleaned has all of its leakage: up to a line's width of damping, and half a line in frequency.

    Parameters
    ----------
    refined
        From the cleaned lines.
    stretch
        The lines as they are.
    leaked
        What they were cleaned by.
    damping
        Law of the modes.
    """
    told = stretch.known and stretch.n_ref == 1 and np.isfinite(leaked.averages)
    refined = replace(refined, fit=_lines_alike(refined.fit, leaked.leakage.error_correlation))
    if told:
        refined = replace(refined, fit=with_leaked_errors(refined, stretch, leaked, damping))
    fit, spacing = refined.fit, float(np.median(np.diff(stretch.freq)))
    whole = np.stack([np.full(len(fit.frequency), spacing / 2), spacing / fit.frequency], axis=1)
    whole[:, 1] = np.minimum(whole[:, 1], fit.loss_factor)  # leakage adds damping
    if leaked.modes is None:
        return replace(refined, leakage_bias=whole)
    known = leaked.modes
    cleaner, same = _cleaned_by(fit, known, spacing)
    vague = same & (known.loss_factor_error > VAGUE * known.loss_factor)[cleaner]
    moves = _moves(refined, stretch, leaked, damping)
    bias = np.where(vague[:, None], leaked.bias[cleaner], _handed_on(moves, leaked, cleaner))
    bias = np.maximum(_left_over(refined, stretch, damping), np.where(same[:, None], bias, whole))
    fit = _no_surer(_moved(fit, moves), known, cleaner, vague)
    return replace(refined, fit=fit, leakage_bias=bias)


@dataclass(frozen=True, eq=False)
class _Moves:
    """How far modes go where all cleaners are off by a standard error: in frequency, and in loss factor."""

    of: FloatArray  # (2, n_modes, 2) frequency, Hz, and loss factor
    constant: FloatArray  # (2, n_modes, n_frf) 1/kg, of either part


def _moves(refined: RefinedModes, stretch: BandData, leaked: LeakageCorrection, damping: Damping) -> _Moves:
    known = leaked.modes
    assert known is not None

    def followed(frequency: FloatArray, loss_factor: FloatArray) -> tuple[FloatArray, ComplexArray]:
        eigenvalue = (2 * np.pi * frequency) ** 2 * (1 + 1j * loss_factor)
        by = replace(leaked, modes=replace(known, eigenvalue=eigenvalue))
        lines = cleaned(stretch, by, damping).receptance
        there, constant = one_step(stretch.freq, lines, refined.weight, refined.fit, damping=damping)
        return np.stack([np.sqrt(there.real) / (2 * np.pi), there.imag / there.real], axis=1), constant

    begun, constant = followed(known.frequency, known.loss_factor)
    steps = (STEP * known.frequency_error, 0.0), (0.0, STEP * known.loss_factor_error)
    ends = [followed(known.frequency + df, known.loss_factor + dn) for df, dn in steps]
    return _Moves(
        np.stack([end - begun for end, _ in ends]) / STEP,
        np.stack([np.abs(end - constant) for _, end in ends]) / STEP / np.sqrt(2),
    )


def _handed_on(moves: _Moves, leaked: LeakageCorrection, cleaner: IntArray) -> FloatArray:
    """Return what the bias of its cleaner moves each mode by, (n_modes, 2)."""
    known = leaked.modes
    assert known is not None
    error = np.stack([known.frequency_error, known.loss_factor_error], axis=1)
    in_errors = (leaked.bias / np.maximum(error, 1e-300))[cleaner]
    return np.asarray((np.abs(moves.of) * in_errors.T[:, :, None]).sum(axis=0))


def _moved(fit: ModalFit, moves: _Moves) -> ModalFit:
    """Return the fit with what errors of the cleaners add to its own."""
    added = (moves.of**2).sum(axis=0).T.ravel()
    constant = (moves.constant**2).sum(axis=0)
    return replace(
        fit,
        eigenvalue_covariance=fit.eigenvalue_covariance + np.diag(added),
        modal_constant_error=np.sqrt(fit.modal_constant_error**2 + constant),
    )


def _lines_alike(fit: ModalFit, alike: float) -> ModalFit:
    """Return the fit with errors of lines that are not independent."""
    return replace(
        fit,
        eigenvalue_covariance=alike * fit.eigenvalue_covariance,
        modal_constant_error=np.sqrt(alike) * fit.modal_constant_error,
    )


def _cleaned_by(fit: ModalFit, known: ModalFit, spacing: float) -> tuple[IntArray, BoolArray]:
    """Return the known mode nearest to each fitted one, and whether it is the same, both (n_modes,)."""
    away = np.abs(fit.frequency[:, None] - known.frequency)
    nearest = away.argmin(axis=1)
    reach = np.maximum((known.loss_factor * known.frequency)[nearest], spacing)
    return nearest, np.asarray(away.min(axis=1) < reach)


def _left_over(refined: RefinedModes, stretch: BandData, damping: Damping) -> FloatArray:
    """Return the part of what cleaning has done that it may have left, as `leakage_bias`."""
    fit = refined.fit
    raw = fit_modes(
        stretch.freq,
        stretch.receptance,
        leaked_weights(fit.eigenvalue, stretch),
        fit.eigenvalue,
        damping=damping,
        participation=fit.participation,
    )
    moved = fit.loss_factor - raw.loss_factor
    spacing = float(np.median(np.diff(stretch.freq)))
    left = LEFT * np.minimum(np.abs(moved), fit.loss_factor)
    return np.stack([np.full_like(left, LEFT_IN_FREQUENCY * spacing), left], axis=1)


def _no_surer(fit: ModalFit, known: ModalFit, cleaner: IntArray, vague: BoolArray) -> ModalFit:
    """Return the fit with no error smaller than that of the vague mode that cleaned its lines."""
    own = np.concatenate([fit.frequency_error, fit.loss_factor_error])
    theirs = np.concatenate([known.frequency_error[cleaner], known.loss_factor_error[cleaner]])
    added = np.where(np.tile(vague, 2), np.maximum(theirs**2 - own**2, 0.0), 0.0)
    constant = np.where(vague[:, None], known.modal_constant_error[cleaner], 0.0)
    return replace(
        fit,
        eigenvalue_covariance=fit.eigenvalue_covariance + np.diag(added),
        modal_constant_error=np.fmax(fit.modal_constant_error, constant),
    )
