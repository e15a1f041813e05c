"""Modes of cleaned lines, with errors that know how leakage was undone, and what it may have left."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.extraction.jointly.fitted import ModalFit
from modallab.extraction.jointly.modal_fit import fit_modes
from modallab.extraction.jointly.refinement import Refined, Stretch
from modallab.extraction.jointly.unleaked import Leaked, leaked_weights
from modallab.extraction.measured.leakage import LEFT
from modallab.extraction.options import Damping


def allowing_for_leakage(refined: Refined, stretch: Stretch, leaked: Leaked, damping: Damping) -> Refined:
    """Return the modes, none surer than the mode that cleaned its lines, and what leakage may have left.

    Cleaned lines agree in part with whatever mode cleaned them: their scatter about it does not tell how
    wrong that is. Of leakage may be left a part of what cleaning has moved a mode by, from a fit of
    the lines as they are, and what is left in the mode that cleaned its lines. A mode that none did has
    all of its leakage: up to a line's width of damping, and half a line in frequency.

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
    fit, spacing = refined.fit, float(np.median(np.diff(stretch.freq)))
    whole = np.stack([np.full(len(fit.frequency), spacing / 2), spacing / fit.frequency], axis=1)
    whole[:, 1] = np.minimum(whole[:, 1], fit.loss_factor)  # leakage adds damping
    if leaked.modes is None:
        return replace(refined, leakage_bias=whole)
    cleaner, same = _cleaned_by(fit, leaked.modes, spacing)
    bias = np.maximum(
        _left_over(refined, stretch, damping), np.where(same[:, None], leaked.bias[cleaner], whole)
    )
    return replace(refined, fit=_no_surer(fit, leaked.modes, cleaner, same), leakage_bias=bias)


def _cleaned_by(fit: ModalFit, known: ModalFit, spacing: float) -> tuple[IntArray, BoolArray]:
    """Return the known mode nearest to each fitted one, and whether it is the same, both (n_modes,)."""
    away = np.abs(fit.frequency[:, None] - known.frequency)
    nearest = away.argmin(axis=1)
    reach = np.maximum((known.loss_factor * known.frequency)[nearest], spacing)
    return nearest, np.asarray(away.min(axis=1) < reach)


def _left_over(refined: Refined, stretch: Stretch, damping: Damping) -> FloatArray:
    """Return the part of what cleaning has moved the modes by that may be left, as `leakage_bias`."""
    fit = refined.fit
    raw = fit_modes(
        stretch.freq,
        stretch.receptance,
        leaked_weights(fit.eigenvalue, stretch),
        fit.eigenvalue,
        damping=damping,
        participation=fit.participation,
    )
    moved = np.stack([fit.frequency - raw.frequency, fit.loss_factor - raw.loss_factor], axis=1)
    most = np.stack([fit.loss_factor * fit.frequency, fit.loss_factor], axis=1)
    return np.asarray(LEFT * np.minimum(np.abs(moved), most))


def _no_surer(fit: ModalFit, known: ModalFit, cleaner: IntArray, same: BoolArray) -> ModalFit:
    """Return the fit with no error smaller than that of the mode that cleaned its lines."""
    own = np.concatenate([fit.frequency_error, fit.loss_factor_error])
    theirs = np.concatenate([known.frequency_error[cleaner], known.loss_factor_error[cleaner]])
    added = np.where(np.tile(same, 2), np.maximum(theirs**2 - own**2, 0.0), 0.0)
    constant = np.where(same[:, None], known.modal_constant_error[cleaner], 0.0)
    return replace(
        fit,
        eigenvalue_covariance=fit.eigenvalue_covariance + np.diag(added),
        modal_constant_error=np.fmax(fit.modal_constant_error, constant),
    )
