"""From the explanations that were found to the further test that would decide between them."""

from collections.abc import Iterator, Sequence

from modallab.core.progress import Progress, part
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.result import NextTest
from modallab.diagnosis.searching.acceptance import ALIKE, model_probabilities, variance_inflation
from modallab.diagnosis.searching.search_path import AcceptedEffect, SearchPath
from modallab.diagnosis.test_design.next_test import Explanation, propose
from modallab.rig.change import Change

SURE = 0.95  # probability above which an explanation has no rivals left
POSSIBLE = 0.01  # probability of a rival that a test is worth doing for
MOST = 3  # rivals that a test is chosen for


def next_test(
    predictor: Predictor, path: SearchPath, done: Sequence[Change], progress: Progress
) -> NextTest | None:
    """Return the test that would tell what was found from its rivals; None where none are left.

    Parameters
    ----------
    done
        What was changed for the further tests that the path explains already.
    """
    rivals = sorted(_rivals(predictor, path), key=lambda one: one[0])[:MOST]
    if not rivals:
        return None
    effects = path.fit.effects
    _, position, _ = rivals[0]
    best = Explanation(effects, effects[position].kind, path.fit.nuisance_position)
    others = []
    for i, (_, place, rival) in enumerate(rivals):
        kind = rival.effects[-1].kind
        progress(0.2 * i / len(rivals), f"fitting {kind} beside all the others")
        exchanged = (*effects[:place], rival.effects[-1], *effects[place + 1 :])
        # Beside one effect alone it was fitted already.
        fitted = rival if len(effects) == 1 else fit(predictor, exchanged)
        others.append(Explanation(fitted.effects, kind, fitted.nuisance_position))
    return propose(predictor, best, others, done=done, progress=part(progress, 0.2, 1.0))


def _rivals(predictor: Predictor, path: SearchPath) -> Iterator[tuple[float, int, Fit]]:
    """Return by how much chi-square tells a rival from what was found, which effect it rivals, its fit."""
    names = [(effect.kind, str(effect.at)) for effect in path.fit.effects]
    for step in path.steps:
        chosen = named(step)
        for other in possible(predictor, step, chosen):
            yield other.chi_square - chosen.chi_square, names.index(step.kind_and_place), other


def named(step: AcceptedEffect) -> Fit:
    """Return the fit of a step's round that has the effect it accepted."""
    last = ((one, one.effects[-1]) for one in step.round_fits)
    return next(one for one, effect in last if (effect.kind, str(effect.at)) == step.kind_and_place)


def alike(predictor: Predictor, step: AcceptedEffect, chosen: Fit) -> list[Fit]:
    """Return the fits of a step's round that leave as much as the one chosen, within random error.

    Of those on one side of the drive point the simplest: a mass is as good as an oscillator tuned far
    above the band. But a simple model does not clear the rig: a stinger's bending has a number more than
    the rotational spring that it is to the structure.
    """
    near = ALIKE * variance_inflation(predictor, step.round_fits[0])
    pool = [one for one in step.round_fits if abs(one.chi_square - chosen.chi_square) < near]
    fewest = {
        side: min(n for n, own in map(_counted, pool) if own == side) for _, side in map(_counted, pool)
    }
    return [one for one in pool if one is not chosen and one.n_parameters == fewest[_counted(one)[1]]]


def _counted(one: Fit) -> tuple[int, bool]:
    """Return how many numbers a fit has, and whether its last effect belongs to the structure."""
    return one.n_parameters, one.effects[-1].structural


def possible(predictor: Predictor, step: AcceptedEffect, chosen: Fit) -> list[Fit]:
    """Return the rivals that are left: those alike, and, unless the one chosen is sure, the probable ones."""
    shares = model_probabilities(predictor, step.round_fits)
    by_fit = list(zip(step.round_fits, shares, strict=True))
    sure = any(one is chosen and share >= SURE for one, share in by_fit)
    near = alike(predictor, step, chosen)
    probable = [one for one, share in by_fit if not sure and one is not chosen and share >= POSSIBLE]
    return [*near, *(one for one in probable if one not in near)]
