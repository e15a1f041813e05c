"""Values of one effect's numbers that a test hardly tells apart."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.special import expit

from modallab.diagnosis.fitting.covariance import ParameterErrors
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import variance_inflation


def resolve_equivalents(predictor: Predictor, found: Fit) -> Fit:
    """Return a fit with each effect as itself or as its lookalike, whichever explains more.

    Its standard errors reach as far as the other one does, by how likely that one is.
    """
    for i, effect in enumerate(found.effects):
        other = effect.equivalent(predictor.setup)
        if other is not None:
            effects = [*found.effects[:i], other, *found.effects[i + 1 :]]
            rival = fit(predictor.with_nuisances_at(found.nuisance_position), effects)
            best, second = (found, rival) if found.chi_square <= rival.chi_square else (rival, found)
            apart = (second.chi_square - best.chi_square) / variance_inflation(predictor, best)
            share = float(expit(-apart / 2))
            found = replace(best, spread=partial(_reaching, best.spread, best, second, i, share))
    return found


def _reaching(
    own: Callable[[], ParameterErrors], best: Fit, second: Fit, which: int, share: float
) -> ParameterErrors:
    """Return the root mean square distance of both fits' laws from the best of both."""
    errors, other = own(), second.errors[which]
    here, there = best.effects[which].parameters, second.effects[which].parameters
    effects = list(errors.effects)
    effects[which] = {
        name: float(
            np.sqrt((1 - share) * error**2 + share * (other[name] ** 2 + (there[name] - here[name]) ** 2))
        )
        for name, error in effects[which].items()
    }
    return replace(errors, effects=tuple(effects))
