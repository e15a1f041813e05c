"""Deviation that many nuisance parameters of a kind have in common: within tolerances, and beyond chance."""

from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import variance_inflation
from modallab.diagnosis.searching.gap_tests import is_noise_only
from modallab.diagnosis.searching.search_path import AcceptedEffect, SearchPath, kind_and_place
from modallab.diagnosis.searching.settings import ACCEPTANCE
from modallab.diagnosis.searching.suspects import Suspects
from modallab.rig.effect import EFFECTS, Effect

COMMON_EFFECTS = {"modal_loss_factor": "loss_factor_error", "sensitivity": "gain_error"}
"""Kind of the effect on the whole test that moves all parameters of a tolerance alike."""


def with_common_deviation(predictor: Predictor, start: Fit, suspects: Suspects) -> SearchPath:
    """Return the path with an effect in place of a common deviation; without one if none is significant.

    Each of many modes may be two standard deviations less lossy than modelled; that all of them are is as
    improbable as one that is two times the root of their number. One loss factor costs one parameter.

    Parameters
    ----------
    start
        The fit without any effect, which leaves random error alone.
    """
    suspected = {kind_and_place(effect) for effect in suspects.effects}
    for name, kind in COMMON_EFFECTS.items():
        effect = EFFECTS[kind](at=None)
        if kind_and_place(effect) not in suspected:
            continue
        candidate = _fit_of_common(predictor, start, name, effect)
        if candidate is None or not is_noise_only(predictor, candidate):
            continue
        gain = (start.bic - candidate.bic) / variance_inflation(predictor, candidate)
        if gain > ACCEPTANCE.very_strong_bic:
            name_and_place = kind_and_place(effect)
            return SearchPath(start, (AcceptedEffect(name_and_place, start, candidate, (candidate,)),))
    return SearchPath(start)


def _fit_of_common(predictor: Predictor, start: Fit, name: str, effect: Effect) -> Fit | None:
    """Return a fit with the effect in place of the mean deviation; None if that may be chance."""
    indices = predictor.nuisances.indices_of(name)
    position = start.nuisance_position.copy()
    if len(indices) < 2:
        return None
    mean = float(position[indices].mean())
    if len(indices) * mean**2 < ACCEPTANCE.very_strong_bic:
        return None
    position[indices] -= mean
    amount = next(iter(effect.specs()))
    factor = predictor.nuisances.parameters[indices[0]].value(mean)
    missing = effect.with_parameters({amount: factor})
    return fit(predictor.with_nuisances_at(position), (missing,))
