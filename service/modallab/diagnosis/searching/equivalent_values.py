"""Equivalent values of an effect's parameters, which a test hardly distinguishes."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.special import expit

from modallab.diagnosis.fitting.covariance import ParameterErrors
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import variance_inflation


def resolve_equivalents(predictor: Predictor, original: Fit) -> Fit:
    """Return a fit with each effect at its own or its equivalent values, whichever explain more.

    Its standard errors include the distance to the other values, weighted by their probability.
    """
    best = original
    for i, effect in enumerate(original.effects):
        equivalent = effect.equivalent(predictor.setup)
        if equivalent is not None:
            effects = [*best.effects[:i], equivalent, *best.effects[i + 1 :]]
            alternative = fit(predictor.with_nuisances_at(best.nuisance_position), effects)
            first, second = (
                (best, alternative) if best.chi_square <= alternative.chi_square else (alternative, best)
            )
            difference = (second.chi_square - first.chi_square) / variance_inflation(predictor, first)
            probability = float(expit(-difference / 2))
            compute_errors = partial(_mixture_errors, first.compute_errors, first, second, i, probability)
            best = replace(first, compute_errors=compute_errors)
    return best


def _mixture_errors(
    compute_errors: Callable[[], ParameterErrors], best: Fit, second: Fit, index: int, probability: float
) -> ParameterErrors:
    """Return the root mean square deviation of the mixture of two fits from the values of the best one.

    Parameters
    ----------
    compute_errors
        Errors of the best fit alone.
    index
        Index of the effect that differs.
    probability
        Probability of the second fit.
    """
    errors, second_errors = compute_errors(), second.errors[index]
    values, second_values = best.effects[index].parameters, second.effects[index].parameters
    effects = list(errors.effects)
    effects[index] = {
        name: float(
            np.sqrt(
                (1 - probability) * error**2
                + probability * (second_errors[name] ** 2 + (second_values[name] - values[name]) ** 2)
            )
        )
        for name, error in effects[index].items()
    }
    return replace(errors, effects=tuple(effects))
