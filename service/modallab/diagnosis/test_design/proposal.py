"""Proposal of the further test that distinguishes the named explanation from its rivals."""

from collections.abc import Iterator, Sequence

from modallab.core.progress import Progress, part
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.result import NextTest
from modallab.diagnosis.searching.acceptance import model_probabilities
from modallab.diagnosis.searching.equivalent_fits import equivalent_fits, named_fit
from modallab.diagnosis.searching.search_path import AcceptedEffect, SearchPath
from modallab.diagnosis.test_design.next_test import Explanation, propose
from modallab.diagnosis.test_design.settings import RIVALS
from modallab.rig.change import Change


def next_test(
    predictor: Predictor, path: SearchPath, previous_changes: Sequence[Change], progress: Progress
) -> NextTest | None:
    """Return the test that distinguishes the named effects from their rivals; None if no rival is left.

    Parameters
    ----------
    previous_changes
        Changes of the further tests that the path explains already.
    """
    nearest = sorted(_rivals(predictor, path), key=lambda rival: rival[0])[: RIVALS.max_rivals]
    if not nearest:
        return None
    effects = path.fit.effects
    _, position, _ = nearest[0]
    best = Explanation(effects, effects[position].kind, path.fit.nuisance_position)
    rivals = []
    for i, (_, place, rival) in enumerate(nearest):
        kind = rival.effects[-1].kind
        progress(0.2 * i / len(nearest), f"fitting {kind} together with the other effects")
        exchanged = (*effects[:place], rival.effects[-1], *effects[place + 1 :])
        # The fit of its round is the one that is sought if there is a single effect.
        fitted = rival if len(effects) == 1 else fit(predictor, exchanged)
        rivals.append(Explanation(fitted.effects, kind, fitted.nuisance_position))
    return propose(
        predictor, best, rivals, previous_changes=previous_changes, progress=part(progress, 0.2, 1.0)
    )


def _rivals(predictor: Predictor, path: SearchPath) -> Iterator[tuple[float, int, Fit]]:
    """Yield the chi-square difference of each rival, the position of the effect it rivals, and its fit."""
    names = [(effect.kind, str(effect.at)) for effect in path.fit.effects]
    for step in path.steps:
        chosen = named_fit(step)
        for rival in possible_rivals(predictor, step, chosen):
            yield rival.chi_square - chosen.chi_square, names.index(step.kind_and_place), rival


def possible_rivals(predictor: Predictor, step: AcceptedEffect, chosen: Fit) -> list[Fit]:
    """Return the equivalent fits and, unless the chosen one is certain, the probable ones."""
    pairs = list(zip(step.round_fits, model_probabilities(predictor, step.round_fits), strict=True))
    certain = any(candidate is chosen and p >= RIVALS.certain for candidate, p in pairs)
    equivalent = equivalent_fits(predictor, step, chosen)
    if certain:
        return equivalent
    probable = [candidate for candidate, p in pairs if candidate is not chosen and p >= RIVALS.possible]
    return [*equivalent, *(candidate for candidate in probable if candidate not in equivalent)]
