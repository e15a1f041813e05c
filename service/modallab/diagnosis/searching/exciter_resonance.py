"""Fits of exciter dynamics whose resonance lies between coarse lines: repeated from the best frequency."""

import numpy as np

from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import is_noise_only
from modallab.diagnosis.searching.settings import RESONANCE
from modallab.rig.effect import Effect, Stage


def with_resonance_at_lines(predictor: Predictor, candidate: Fit, near: Fit) -> Fit:
    """Return a fit whose last effect begins at the stiffness that fits all lines best, if that is better.

    An armature on a soft stinger resonates within a line or two: coarse predictions, of every third line, may
    have none of these, and then lead the fit to another frequency. Effects that change the exciter alone,
    beside more than random error; the candidate in all other cases.

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
