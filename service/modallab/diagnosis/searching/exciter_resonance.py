"""Fits of exciter dynamics whose resonance lies between coarse lines: repeated from the best frequency."""

import numpy as np

from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.gap_tests import is_noise_only
from modallab.diagnosis.searching.round_settings import RESONANCE
from modallab.rig.effect import Effect, Stage


def with_resonance_at_lines(predictor: Predictor, candidate: Fit, near: Fit) -> Fit:
    """Return a fit whose last effect starts at the size that fits all lines best, if its chi-square is lower.

    The resonance of an armature on a soft stinger is a line or two wide: coarse predictions, which have some
    of the lines, may miss it, and the fit then ends at another frequency. The candidate is returned where its
    last effect does not act on the exciter, or leaves random error alone.

    Parameters
    ----------
    near
        As in `fit`.
    """
    effect = candidate.effects[-1]
    if effect.stage is not Stage.DRIVE or is_noise_only(predictor, candidate):
        return candidate
    others, at_fit = candidate.effects[:-1], predictor.with_nuisances_at(candidate.nuisance_position)
    (name, spec), *_ = effect.specs().items()
    ratios = np.geomspace(1 / RESONANCE.largest_ratio, RESONANCE.largest_ratio, RESONANCE.n_values)
    values = np.clip(effect.parameters[name] * ratios, spec.lower, spec.upper)

    def chi_square(trial: Effect) -> float:
        vector = at_fit.residual([*others, trial]).vector(at_fit.observed.fitted)
        return float(vector @ vector)

    start = min((effect.with_parameters({name: float(value)}) for value in values), key=chi_square)
    found = fit(predictor, (*others, start), near=near)
    return min(candidate, found, key=lambda each: each.chi_square)
