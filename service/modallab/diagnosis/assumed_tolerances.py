"""Fits of a search under stated tolerances, repeated under assumed ones."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain, compress

import numpy as np
from scipy.special import chdtr, chdtri

from modallab.diagnosis.fitting.fit import Fit, fit, with_optional_parameters
from modallab.diagnosis.fitting.settings import FIT
from modallab.diagnosis.optimisation.nuisances import Nuisances
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.search_result import SearchResult
from modallab.diagnosis.searching.acceptance import is_significant, ranked_by_bic
from modallab.diagnosis.searching.gap_tests import is_noise_only
from modallab.diagnosis.searching.limiting_fits import with_limiting_effects
from modallab.diagnosis.searching.round_settings import ROUND
from modallab.diagnosis.searching.search_path import AcceptedEffect, SearchPath, kind_and_place, refine_path
from modallab.diagnosis.settings import DIAGNOSIS
from modallab.rig.effect import Effect


def refitted_round(fits: Sequence[Fit], second: SearchResult, alone: Fit) -> list[Fit] | None:
    """Return fits of single effects under the second tolerances; None if tolerances may hide the largest.

    That is where they close as much of the gap as the best effect does.

    Parameters
    ----------
    alone
        Fit of the effects of the first search under the second tolerances.
    """
    if not fits or _may_hide_effect(fits[0], alone, second.path.fit):
        return None
    return _refitted(fits, second, alone)


def _refitted(fits: Sequence[Fit], second: SearchResult, alone: Fit) -> list[Fit]:
    """Return the competitive fits of single effects under the second tolerances, best first.

    What the best one tends to is fitted from there: from elsewhere its tolerances may end in another minimum.
    """
    limit = ROUND.competitive_cost * fits[0].chi_square
    # Beside an effect that leaves noise alone, one that leaves far more is no rival.
    explained = is_noise_only(second.predictor, alone)
    n_least = 1 if explained else ROUND.min_fits
    competitive = [one for i, one in enumerate(fits) if i < n_least or one.chi_square < limit]
    position = alone.nuisance_position if explained else second.path.fit.starting_position
    predictor = second.predictor.with_nuisances_at(position)
    max_chi_square = FIT.near_noise * alone.chi_square if explained else np.inf

    def refitted(single: Fit) -> Fit:
        if kinds_and_places(single.effects) == kinds_and_places(alone.effects):
            return alone
        is_rival = single.chi_square < ROUND.refitted_cost * fits[0].chi_square
        limit = np.inf if is_rival else max_chi_square
        found = fit(predictor, single.effects, near=second.path.fit, max_chi_square=limit)
        if found.chi_square > max_chi_square:
            return found
        return with_optional_parameters(predictor, found, second.path.fit)

    found = [refitted(single) for single in competitive]
    names = {kind_and_place(single.effects[-1]) for single in fits}
    return ranked_by_bic(with_limiting_effects(second.predictor, second.path.fit, found, names))


def near_data_round(fits: Sequence[Fit], first: SearchResult) -> list[Fit]:
    """Return fits of single effects under the first tolerances, of those that come near the data there.

    The first ones are fitted to their ends, until one comes near; the others have to in a few steps.

    Parameters
    ----------
    fits
        Of single effects under other tolerances.
    """
    start = first.path.fit
    predictor = first.predictor.with_nuisances_at(start.starting_position)
    found: list[Fit] = []
    for one in fits:
        patient = len(found) < ROUND.min_fits and not any(each.is_near_data for each in found)
        limit = np.inf if patient else FIT.near_noise * start.n_data
        found.append(fit(predictor, one.effects, near=start, max_chi_square=limit))
    near = [with_optional_parameters(predictor, each, start) for each in found if each.is_near_data]
    return ranked_by_bic(near)


def refitted_path(path: SearchPath, second: SearchResult) -> SearchPath | None:
    """Return a path under the second tolerances, if its effects explain the measurement there.

    None, too, of a single effect that is not significant beside the tolerances: they explain as much.
    """
    effects = path.fit.effects
    if not effects or not second.explains(effects):
        return None
    start, last, alone = second.path.start, path.steps[-1], second.with_effects(effects)
    if len(effects) > 1:  # the refinement fits the rivals of each effect beside the others
        steps = (*path.steps[:-1], replace(last, fit=alone))
    else:
        order = tuple(_refitted(last.round_fits, second, alone))
        if not is_significant(second.predictor, start, order[0]):
            return None
        steps = (AcceptedEffect(kind_and_place(order[0].effects[-1]), start, order[0], order),)
    return refine_path(second.predictor, SearchPath(start, steps))


def may_hide_effects(path: SearchPath, second: SearchResult) -> bool:
    """Return whether the second tolerances may hide an effect of a path: they close as much of the gap."""
    effects = path.fit.effects
    complete = second.with_effects(effects)
    without_one = [second.with_effects(effects[:i] + effects[i + 1 :]) for i in range(len(effects))]
    return any(_may_hide_effect(path.fit, complete, reduced) for reduced in without_one)


def explains_more(under_stated: Fit, under_assumed: Fit) -> bool:
    """Return whether a fit explains more than one with more tolerances free, which has missed an effect.

    With more effects it has to leave far less: they may imitate what the assumed tolerances allow.
    """
    excess, other_excess = (found.chi_square - found.n_data for found in (under_stated, under_assumed))
    imitating = len(under_stated.effects) > len(under_assumed.effects)
    return excess < (DIAGNOSIS.far_less if imitating else 1.0) * other_excess


def _may_hide_effect(under_stated: Fit, under_assumed: Fit, without_effect: Fit) -> bool:
    """Return whether assumed tolerances may hide which effect is missing: they close as much of the gap.

    Parameters
    ----------
    under_stated, under_assumed
        Fits with the effect under both tolerances.
    without_effect
        Fit under the assumed tolerances without the effect.
    """
    by_tolerances = under_stated.chi_square - under_assumed.chi_square
    by_effect = without_effect.chi_square - under_assumed.chi_square
    return ROUND.competitive_cost * by_tolerances > by_effect


def kinds_and_places(effects: Sequence[Effect]) -> list[tuple[str, str]]:
    """Return kind and place of each of some effects."""
    return [kind_and_place(effect) for effect in effects]


def deviate_far(nuisances: Nuisances, found: Fit, stated: Tolerances) -> bool:
    """Return whether nuisance parameters of assumed tolerances deviate farther than a single effect costs.

    Those of modes and of random fields are many, and deviate in any model that is a little wrong: only the
    squares of all deviations together, if they are more than chance, make an effect more likely.
    """
    squares = found.nuisance_position**2
    of_rig_or_model = [
        nuisance.mode is None and nuisance.shape is None and nuisance.name not in stated.stated
        for nuisance in nuisances.parameters
    ]
    cost = found.cost_per_parameter / found.correlation_length
    by_chance = chdtri(max(len(squares), 1), DIAGNOSIS.deviation_probability)
    return bool(squares[of_rig_or_model].sum() > cost or squares.sum() > by_chance)


def deviates_alone(nuisances: Nuisances, found: Fit, stated: Tolerances) -> bool:
    """Return whether the deviations of all assumed tolerances but one are negligible, and not by chance.

    A model that is exact elsewhere has an effect there rather than a deviation. Deviations that the data do
    not determine are left out.
    """
    determined = found.nuisance_errors < DIAGNOSIS.determined_error
    names = compress([nuisance.name for nuisance in nuisances.parameters], determined)
    values = np.column_stack([found.nuisance_position, found.nuisance_errors])[determined] ** 2
    groups: dict[str, list[list[float]]] = {}
    for name, squares in zip(names, values.tolist(), strict=True):
        if name not in stated.stated:
            groups.setdefault(name, []).append(squares)
    remaining = list(chain.from_iterable(sorted(groups.values(), key=max)[:-1]))
    total, of_errors = np.sum(remaining, axis=0) if remaining else (0.0, 0.0)
    negligible = total < of_errors + len(remaining) * DIAGNOSIS.negligible_deviation**2
    return bool(negligible and chdtr(len(remaining), total) < DIAGNOSIS.deviation_probability)
