"""Fits of what the best effect tends to at the limits of its parameters, and of its reduced model."""

from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import replace

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.acceptance import is_undetermined
from modallab.diagnosis.searching.round_settings import ROUND
from modallab.diagnosis.searching.search_path import kind_and_place
from modallab.rig.effect import Effect


def with_limiting_effects(
    predictor: Predictor, base: Fit, fits: Sequence[Fit], suspected: Collection[tuple[str, str]]
) -> list[Fit]:
    """Return the fits of a round with those of what the best effect tends to, each fitted from there.

    A fit from the scan may have ended elsewhere. Where the data do not determine how near the best effect is
    to such a limit, the limit stands for it.

    Parameters
    ----------
    base
        The fit of the accepted effects.
    fits
        Fits of the accepted effects with one suspect added.
    suspected
        Kinds and places of the suspects.
    """
    if not fits:
        return []
    best = min(fits, key=Fit.bic_between_kinds)
    limits = [_at_own_place(effect, predictor) for effect in best.effects[-1].limiting_effects()]
    predictor = predictor.with_nuisances_at(best.nuisance_position)
    result = list(fits)
    for effect in limits:
        name = kind_and_place(effect)
        if name not in suspected:
            continue
        limit = ROUND.limiting_cost * best.chi_square
        with suppress(InvalidInputError):
            found = fit(predictor, (*base.effects, effect), near=base, max_chi_square=limit)
            of_effect = [f for f in result if kind_and_place(f.effects[-1]) == name]
            if all(found.chi_square < f.chi_square for f in of_effect):
                result = [found, *(f for f in result if f not in of_effect)]
    limit_names = {kind_and_place(effect) for effect in limits}
    max_chi_square = (1 + ROUND.same_cost) * best.chi_square
    fits_of_limits = [f for f in result if kind_and_place(f.effects[-1]) in limit_names]
    if any(f.chi_square < max_chi_square for f in fits_of_limits) and is_undetermined(best):
        result.remove(best)
    return result


def _at_own_place(effect: Effect, predictor: Predictor) -> Effect:
    """Return an effect at the place of its kind at the same node: a mass moves in every direction."""
    places = type(effect).places(predictor.system, predictor.setup)
    if effect.at in places or not isinstance(effect.at, Dof):
        return effect
    at_node = [at for at in places if isinstance(at, Dof) and at.node == effect.at.node]
    return replace(effect, at=at_node[0]) if at_node else effect


def with_reduced_model(
    predictor: Predictor, base: Fit, fits: Sequence[Fit], unfitted: Collection[tuple[str, str]]
) -> list[Fit]:
    """Return the fits of a round with that of the reduced model of the best effect, if it was not fitted.

    Parameters
    ----------
    unfitted
        Kinds and places of the suspects that were not fitted.
    """
    best = min(fits, key=Fit.bic_between_kinds, default=None)
    reduced = None if best is None else best.effects[-1].reduced_model()
    if reduced is not None and kind_and_place(reduced[0]) in unfitted:
        with suppress(InvalidInputError):
            return [*fits, fit(predictor, (*base.effects, reduced[0]), near=base)]
    return list(fits)
