"""Refinement of modes with a search for further poles in its residual."""

from dataclasses import replace

import numpy as np
import scipy

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.core.progress import Progress, part, silent
from modallab.extraction.multi_mode.chart_settings import RANGES
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.modal_fit import fit_modes, fitted_receptance
from modallab.extraction.multi_mode.refinement import (
    BandData,
    RefinedModes,
    StartingPoles,
    between_ends,
    refine,
    refine_all,
)
from modallab.extraction.multi_mode.refinement_settings import RESIDUAL_POLES
from modallab.extraction.multi_mode.residual_poles import Candidates, residual_poles
from modallab.extraction.options import Damping


def refine_with_search(
    band_data: BandData, start: StartingPoles, damping: Damping, progress: Progress
) -> RefinedModes | None:
    """Return the fit of all significant modes, including those that only its residual shows.

    A weak mode, or one of a close pair, may have no stable column in a chart, because noise biases the poles
    of every order. The residual of a fit without it is a resonance in noise: its pole is fitted with all
    others, and eliminated again if it is not significant. Parameters as in `refine`.
    """
    refined = refine(band_data, start, damping, part(progress, 0.0, RESIDUAL_POLES.first_share))
    for _ in range(RESIDUAL_POLES.searches):
        if refined is None:
            return None
        candidates = residual_poles(band_data, _residual(band_data, refined.fit, damping), refined.fit)
        more = None if candidates is None else _with_candidates(band_data, refined, candidates, damping)
        if more is None:
            return refined
        refined = more
    return refined


def _residual(band_data: BandData, fit: ModalFit, damping: Damping) -> ComplexArray:
    return band_data.receptance - fitted_receptance(fit, band_data.freq, damping)


def _with_candidates(
    band_data: BandData, refined: RefinedModes, candidates: Candidates, damping: Damping
) -> RefinedModes | None:
    """Return the fit with those candidates that explain the lines around them; None if there are none."""
    before = _residual(band_data, refined.fit, damping)
    start = _start(refined.fit, candidates)
    fit = fit_modes(
        band_data.freq,
        band_data.receptance,
        refined.weight,
        start.eigenvalue,
        damping=damping,
        participation=start.participation,
        noise=band_data.noise,
    )
    for _ in range(RESIDUAL_POLES.trials):
        proper = _explained(band_data, before, _residual(band_data, fit, damping), candidates)
        candidates = candidates.at(proper & ~doubling(refined.fit, fit, candidates, band_data.freq))
        if not len(candidates.eigenvalue):
            return None
        trial = refine_all(band_data, _start(refined.fit, candidates), damping, silent)
        if trial is None or _n_modes(trial, band_data) <= _n_modes(refined, band_data):
            return None
        fit = trial.fit
        proper = _explained(band_data, before, _residual(band_data, fit, damping), candidates)
        if (proper & ~doubling(refined.fit, fit, candidates, band_data.freq)).all():
            new = _new_modes(refined.fit, fit, band_data.freq)
            width = (fit.loss_factor * fit.frequency)[new]
            low, high = (fit.frequency[new] + sign * width for sign in (-1, 1))
            residual_modes = (*refined.residual_modes, *zip(low.tolist(), high.tolist(), strict=True))
            drifts = (*refined.drifts, *trial.drifts)
            return replace(trial, left_out=refined.left_out, drifts=drifts, residual_modes=residual_modes)
    return None


def _start(fit: ModalFit, candidates: Candidates) -> StartingPoles:
    """Return the poles of a fit and candidates."""
    reach = None
    if fit.participation is not None and candidates.participation is not None:
        reach = np.concatenate([fit.participation, candidates.participation])
    return StartingPoles(np.concatenate([fit.eigenvalue, candidates.eigenvalue]), reach)


def _new_modes(before: ModalFit, after: ModalFit, freq: FloatArray) -> BoolArray:
    """Return the modes in the range that a fit has not had before, or elsewhere, (n_modes,)."""
    width = np.maximum(after.loss_factor * after.frequency, SAFE_DIVISOR)
    distance = np.abs(after.frequency[:, None] - before.frequency) / width[:, None]
    row, earlier = scipy.optimize.linear_sum_assignment(np.minimum(distance, RANGES.match_distance))
    new = between_ends(after, freq) & (after.loss_factor > 0)
    new[row[distance[row, earlier] < RANGES.match_distance]] = False
    return np.asarray(new)


def doubling(before: ModalFit, after: ModalFit, candidates: Candidates, freq: FloatArray) -> BoolArray:
    """Return which candidates became a mode too close to another one, (n_candidates,).

    Two poles describe one mode whose frequency drifts as well as two modes. They are as narrow as it: a broad
    pole over a mode is a residual.
    """
    width = after.loss_factor * after.frequency
    distance = np.abs(after.frequency[:, None] - after.frequency)
    modes = between_ends(after, freq) & (after.loss_factor > 0)
    close = distance < RESIDUAL_POLES.closest * np.minimum(width[:, None], width)
    close &= modes[:, None] & modes & ~np.eye(len(width), dtype=bool)
    doubled = after.frequency[_new_modes(before, after, freq) & close.any(axis=1)]
    out = np.zeros(len(candidates.eigenvalue), bool)
    out[(np.abs(doubled[:, None] - candidates.frequency) / candidates.width).argmin(axis=1)] = True
    return out


def _n_modes(refined: RefinedModes, band_data: BandData) -> int:
    return int((between_ends(refined.fit, band_data.freq) & (refined.fit.loss_factor > 0)).sum())


def _explained(
    band_data: BandData, before: ComplexArray, after: ComplexArray, candidates: Candidates
) -> BoolArray:
    """Return which candidates explain the residual around them, to the noise or for the most part.

    A frequency that drifts, or a nonlinear resonance, leaves a residual too. Poles added there reduce it, and
    would split the mode in two.
    """
    distance = np.abs(band_data.freq[:, None] - candidates.frequency)
    near = (distance <= np.maximum(candidates.width, RESIDUAL_POLES.least_reach * _spacing(band_data))).T
    used = near.astype(float) @ (band_data.weight > 0).sum(axis=1)
    squares = [
        near.astype(float) @ (band_data.weight * np.abs(rest) ** 2).sum(axis=1) for rest in (before, after)
    ]
    at_noise = squares[1] <= RESIDUAL_POLES.noise_ratio * used
    return np.asarray(at_noise | (squares[1] < 0.5 * squares[0]))


def _spacing(band_data: BandData) -> float:
    return float(np.diff(band_data.freq).min())
