"""Putting right what was accepted one after the other."""

import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels, Members
from modallab.core.progress import silent
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.gap_tests import is_noise_only
from modallab.diagnosis.searching.search_path import AcceptedEffect, SearchPath, kind_and_place, refine_path
from modallab.diagnosis.searching.search_round import fit_candidates
from modallab.diagnosis.searching.suspects import Suspects
from modallab.effects.attached_oscillator import AttachedOscillator
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.gain_error import GainError
from modallab.effects.local_damping import LocalDamping
from modallab.effects.stiffness_error import StiffnessError
from modallab.rig.effect import Effect
from tests.diagnosing import draw_measurement, predicting, rig

MASS, GAIN = ExtraMass(Dof(4, "Y"), 0.02), GainError(Channels((Dof(5, "Y"),)), 1.05)
WRONG = StiffnessError(Members((3,)), 0.97)  # what a mass beside it may be taken for at first


@pytest.fixture(scope="module")
def predictor() -> Predictor:
    return predicting(draw_measurement(rig(), [MASS, GAIN], seed=3))[0]


def accepted(predictor: Predictor, first: Effect, others: tuple[Effect, ...], *later: Effect) -> SearchPath:
    """Return the path of a first effect, with others of its round, and later ones."""
    start = fit(predictor, ())
    alone = fit(predictor, (first,))
    tried = (alone, *(fit(predictor, (other,)) for other in others))
    steps = [AcceptedEffect(kind_and_place(first), start, alone, tried)]
    for effect in later:
        before = steps[-1].fit
        after = fit(predictor, (*before.effects, effect))
        steps.append(AcceptedEffect(kind_and_place(effect), before, after, (after,)))
    return SearchPath(start, tuple(steps))


def names(path: SearchPath) -> set[tuple[str, str]]:
    assert {step.kind_and_place for step in path.steps} == {kind_and_place(e) for e in path.fit.effects}
    return {kind_and_place(effect) for effect in path.fit.effects}


def test_a_first_effect_that_a_rival_beats_beside_the_second_gives_way(predictor: Predictor) -> None:
    path = refine_path(predictor, accepted(predictor, WRONG, (MASS,), GAIN))
    assert names(path) == {kind_and_place(MASS), kind_and_place(GAIN)}
    rivals = next(step.round_fits for step in path.steps if step.kind_and_place == kind_and_place(MASS))
    assert kind_and_place(rivals[0].effects[-1]) == kind_and_place(MASS), "the best of its round comes first"
    assert {kind_and_place(one.effects[-1]) for one in rivals} == {
        kind_and_place(MASS),
        kind_and_place(WRONG),
    }
    assert all(len(one.effects) == 2 for one in rivals), "each beside the effect that stays"


def test_a_found_explanation_is_compared_with_its_rivals_though_the_budget_is_spent() -> None:
    predictor = predicting(draw_measurement(rig(), [MASS, GAIN], seed=3))[0]
    oscillator = AttachedOscillator(Dof(4, "Y"), 0.02, frequency=5e3)  # far above the band: a mass
    path = accepted(predictor, oscillator, (MASS,), GAIN)
    assert is_noise_only(predictor, path.fit)
    predictor.budget.scale_limit(0.0)
    assert names(refine_path(predictor, path)) == {kind_and_place(MASS), kind_and_place(GAIN)}


def test_an_effect_next_to_its_true_place_is_moved_there_though_no_fit_of_its_round_was(
    predictor: Predictor,
) -> None:
    beside = ExtraMass(Dof(3, "Y"), 0.02)
    path = refine_path(predictor, accepted(predictor, beside, (), GAIN))
    assert names(path) == {kind_and_place(MASS), kind_and_place(GAIN)}
    pairs = zip(path.fit.effects, path.fit.errors, strict=True)
    mass, errors = next((effect, errors) for effect, errors in pairs if effect.kind == MASS.kind)
    assert abs(mass.parameters["mass"] - MASS.mass) < 4 * errors["mass"]  # four standard errors


def test_what_made_up_for_a_wrong_effect_goes_with_it(predictor: Predictor) -> None:
    made_up = StiffnessError(Members((4,)), 0.98)
    path = refine_path(predictor, accepted(predictor, WRONG, (MASS,), GAIN, made_up))
    assert names(path) == {kind_and_place(MASS), kind_and_place(GAIN)}


def test_a_needless_effect_is_taken_out(predictor: Predictor) -> None:
    path = refine_path(predictor, accepted(predictor, WRONG, (), MASS, GAIN))
    assert names(path) == {kind_and_place(MASS), kind_and_place(GAIN)}


def test_the_effect_that_explains_most_comes_first(predictor: Predictor) -> None:
    for first, second in ((MASS, GAIN), (GAIN, MASS)):
        path = refine_path(predictor, accepted(predictor, first, (), second))
        assert path.steps[0].kind_and_place == kind_and_place(MASS)
        assert path.steps[0].previous_fit is path.start


def test_what_is_accepted_is_not_suspected_again_at_its_place(predictor: Predictor) -> None:
    elsewhere = LocalDamping(Dof(7, "Y"), 1.0)
    suspects = Suspects([MASS, ExtraMass(Dof(7, "Y")), elsewhere])
    assert MASS not in suspects.of(predictor, [MASS.with_parameters({"mass": 0.03})])
    found = fit_candidates(predictor, fit(predictor, (MASS,)), suspects, progress=silent)
    assert kind_and_place(MASS) not in {kind_and_place(one.effects[-1]) for one in found}
