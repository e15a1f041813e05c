"""Fits of effects in bursts whose random errors are too wide: repeated from smaller effects."""

from collections.abc import Sequence

import numpy as np

from modallab.diagnosis.fitting.fit import Fit, chi_square_with_own_errors, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.gap_tests import parts_with_wide_errors
from modallab.diagnosis.searching.round_settings import NARROWING
from modallab.diagnosis.searching.starting_values import with_amount_scaled
from modallab.rig.effect import Effect


def with_narrower_errors(predictor: Predictor, candidate: Fit, near: Fit) -> Fit:
    """Return a fit whose errors are those of its data; the candidate, if no smaller effect is likelier.

    The random errors of an intermittent effect are those of its size at the start of the fit. If they are far
    too large they forgive any residual, and the fit ends near that start. With the errors of one size the fit
    may also end at a larger effect, which is less likely with its own errors: its size then changes by half a
    step at most, or not at all.

    Parameters
    ----------
    near
        As in `fit`.
    """
    if not parts_with_wide_errors(predictor, candidate):
        return candidate
    predictor = predictor.with_nuisances_at(candidate.nuisance_position)
    effects, least = candidate.effects, chi_square_with_own_errors(predictor, candidate.effects)
    for _ in range(NARROWING.max_steps):
        smaller = _with_smaller_bursts(effects)
        chi_square = chi_square_with_own_errors(predictor, smaller)
        if chi_square >= least:
            break
        effects, least = smaller, chi_square
    if effects == candidate.effects:
        return candidate
    for largest_ratio in (np.inf, NARROWING.ratio**-0.5):
        found = fit(predictor, effects, near=near, largest_ratio=largest_ratio)
        fitted = predictor.with_nuisances_at(found.nuisance_position)
        if chi_square_with_own_errors(fitted, found.effects) <= least:
            return found
    return fit(predictor, effects, near=near, largest_ratio=1.0)


def _with_smaller_bursts(effects: Sequence[Effect]) -> tuple[Effect, ...]:
    return tuple(
        with_amount_scaled(effect, NARROWING.ratio) if effect.intermittent else effect for effect in effects
    )
