"""A round of the search."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

import modallab.diagnosis.searching.search_round as module
from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.core.progress import silent
from modallab.diagnosis.fitting.coarse_fit import coarse_fit
from modallab.diagnosis.fitting.covariance import ParameterErrors
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.optimisation.nuisance_parameters import nuisance_parameters
from modallab.diagnosis.optimisation.nuisances import draw_positions
from modallab.diagnosis.optimisation.tolerances import TolerancePreset, Tolerances
from modallab.diagnosis.predicting.prediction_budget import PredictionBudget
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.round_settings import ROUND
from modallab.diagnosis.searching.scanning import StartingPoint, scan
from modallab.diagnosis.searching.search_round import fit_candidates
from modallab.diagnosis.searching.settings import ACCEPTANCE
from modallab.diagnosis.searching.suspects import Suspects
from modallab.effects.attached_oscillator import AttachedOscillator
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.density_error import DensityError
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.force_transducer_mass import ForceTransducerMass
from modallab.effects.ground_spring import GroundSpring
from modallab.effects.joint_flexibility import JointFlexibility
from modallab.effects.loss_factor_error import LossFactorError
from modallab.effects.stiffness_error import StiffnessError
from modallab.effects.suspension import SuspensionStiffness
from modallab.rig.effect import Effect
from tests.diagnosing import draw_measurement, predicting, rig


def recorded_scans(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the kinds of all effects that are scanned, filled as they are."""
    kinds: list[str] = []

    def scan_and_record(*given: Any) -> list[StartingPoint]:
        kinds.extend(effect.kind for effect in given[2])
        return scan(*given)

    monkeypatch.setattr(module, "scan", scan_and_record)
    return kinds


def test_a_place_that_the_scan_takes_for_its_neighbour_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    hidden = ExtraMass(Dof(6, "Y"), 0.1)
    predictor, _ = predicting(draw_measurement(rig(), [hidden]))
    starts = [StartingPoint(ExtraMass(Dof(5, "Y"), 0.08), 0.03)]
    monkeypatch.setattr(module, "scan", lambda *_: starts)
    suspects = Suspects([ExtraMass(Dof(node, "Y")) for node in range(1, 10)])
    best, *others = fit_candidates(predictor, fit(predictor, ()), suspects, progress=silent)
    assert best.effects[-1].at == hidden.at
    assert {4, 5, 7} == {f.effects[-1].at.node for f in others if isinstance(f.effects[-1].at, Dof)}


def test_a_neighbour_that_the_scan_did_not_list_may_be_the_explanation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hidden = ExtraMass(Dof(6, "Y"), 0.1)
    # a model that is a little wrong everywhere: what is left is more than noise
    predictor, _ = predicting(draw_measurement(rig(), [StiffnessError(None, 1.005), hidden]))
    starts = [StartingPoint(ExtraMass(Dof(5, "Y"), 0.08), 0.03)]
    monkeypatch.setattr(module, "scan", lambda *_: starts)
    masses = [ExtraMass(Dof(node, "Y")) for node in range(1, 10)]
    suspects = Suspects([*masses, CubicStiffness(Dof(7, "Y"))])
    best, *_ = fit_candidates(
        predictor, fit(predictor, ()), suspects, progress=silent, explains=lambda _: True
    )
    assert best.effects[-1].at == hidden.at


def test_neighbours_of_every_place_that_does_as_well_are_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    """An oscillator on a frame was named three nodes away: four places did as well, two were fitted."""
    predictor, _ = predicting(draw_measurement(rig(noise=0.1), [ExtraMass(Dof(6, "Y"), 0.001)]))
    starts = [StartingPoint(ExtraMass(Dof(3, "Y"), 0.001), 0.03)]
    monkeypatch.setattr(module, "scan", lambda *_: starts)
    suspects = Suspects([ExtraMass(Dof(node, "Y")) for node in range(1, 10)])
    fits = fit_candidates(predictor, fit(predictor, ()), suspects, progress=silent)
    places = {f.effects[-1].at.node: f.chi_square for f in fits if isinstance(f.effects[-1].at, Dof)}
    limit = min(places.values()) + ACCEPTANCE.equivalence_chi_square
    alike = {node for node, chi_square in places.items() if chi_square <= limit}
    assert len(alike) > 1  # among them 2, which has but one neighbour in common with the best
    assert all({node - 1, node + 1} - {0, 10} <= set(places) for node in alike)


def test_an_effect_that_changes_nothing_is_not_followed_from_place_to_place(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Beside a density that explained all, loss factors of 87 members were fitted, none of them better."""
    predictor, _ = predicting(draw_measurement(rig()))
    losses = [LossFactorError(Members((number,)), 1.001) for number in range(1, 9)]
    monkeypatch.setattr(module, "scan", lambda *_: [StartingPoint(losses[3], 0.03)])
    found = fit_candidates(predictor, fit(predictor, ()), Suspects(losses), progress=silent)
    assert {str(single.effects[-1].at) for single in found} == {f"members {number}" for number in (3, 4, 5)}


def test_a_mass_at_the_end_of_the_member_that_is_nearest_to_it_is_fitted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hidden = ExtraMass(Dof(6, "Y"), 0.1)
    predictor, _ = predicting(draw_measurement(rig(), [hidden]))
    member = DensityError(Members((5,)), 1.3)

    def without_masses_at_first(*given: Any) -> list[StartingPoint]:
        suspects = given[2]
        return [StartingPoint(member, 0.03)] if member in suspects else scan(*given)

    monkeypatch.setattr(module, "scan", without_masses_at_first)
    suspects = Suspects([member, *(ExtraMass(Dof(node, "Y")) for node in range(1, 10))])
    best, *_ = fit_candidates(predictor, fit(predictor, ()), suspects, progress=silent)
    assert (best.effects[-1].kind, best.effects[-1].at) == (hidden.kind, hidden.at)
    assert best.effects[-1].parameters["mass"] == pytest.approx(0.1, rel=0.01)  # noise of 1e-4


def test_beside_an_explanation_what_acts_much_like_it_is_fitted_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """A band at the end of a beam was `explained` by a spring without loss: other bands were fitted."""
    hidden = SuspensionStiffness(Dof(1, "Y"), 2000.0, 0.2)
    predictor, _ = predicting(draw_measurement(rig(), [hidden]))
    base, spring, band = fit(predictor, ()), GroundSpring(Dof(1, "Y")), SuspensionStiffness(Dof(1, "Y"))

    def without_bands_at_first(*given: Any) -> list[StartingPoint]:
        return [] if spring in given[2] else scan(*given)

    monkeypatch.setattr(module, "scan", without_bands_at_first)
    known = fit(predictor, (spring,), near=base)
    best, *_ = fit_candidates(predictor, base, Suspects([spring, band]), progress=silent, explanation=known)
    assert (best.effects[-1].kind, best.effects[-1].at) == (hidden.kind, hidden.at)
    assert best.effects[-1].parameters["loss_factor"] == pytest.approx(0.2, rel=0.05)  # noise of 1e-4


def test_of_a_model_wrong_everywhere_a_fit_begins_at_the_declared_values_too(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hidden = ExtraMass(Dof(6, "Y"), 0.05)
    declared, _ = predicting(draw_measurement(rig(noise=1e-5)))
    student = Tolerances.preset(TolerancePreset.STUDENT)
    nuisances = nuisance_parameters(student, declared.system, declared.setup)
    wrong_everywhere = nuisances.effects(draw_positions(len(nuisances), np.random.default_rng(4)))
    predictor, _ = predicting(draw_measurement(rig(noise=1e-5), [*wrong_everywhere, hidden], seed=4))
    predictor = predictor.with_nuisances(nuisances)
    without = fit(predictor, ())

    monkeypatch.setattr(module, "scan", lambda *_: [StartingPoint(ExtraMass(Dof(6, "Y"), 0.003), 0.03)])
    found, *_ = fit_candidates(predictor, without, Suspects([ExtraMass(Dof(6, "Y"))]), progress=silent)
    assert found.chi_square < 1.1 * found.n_data  # 1,900 squares scatter by 3 %
    assert found.effects[-1].parameters["mass"] == pytest.approx(0.05, rel=0.02)


def test_a_rival_whose_fit_ended_elsewhere_is_fitted_from_the_tolerances_of_the_explanation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A mass at the drive point was named at probability 1.0: that of the transducer had a poor fit."""
    predictor, _ = predicting(draw_measurement(rig(noise=1e-5), [ForceTransducerMass(mass=0.014)], seed=4))
    ordinary = Tolerances.preset(TolerancePreset.ORDINARY)
    predictor = predictor.with_nuisances(nuisance_parameters(ordinary, predictor.system, predictor.setup))
    ended: list[Effect] = []

    def elsewhere(predictor: Predictor, effects: Sequence[Effect], **options: Any) -> Fit:
        found = fit(predictor, effects, **options)
        if isinstance(effects[-1], ForceTransducerMass) and not ended:
            ended.append(effects[-1])
            poor = effects[-1].with_parameters({"mass": 0.012})
            return replace(found, effects=(poor,), chi_square=10 * found.chi_square)
        return found

    monkeypatch.setattr(module, "fit", elsewhere)
    suspects = Suspects([ForceTransducerMass(), ExtraMass(Dof(1, "Y")), ExtraMass(Dof(6, "Y"))])
    candidates = fit_candidates(predictor, fit(predictor, ()), suspects, progress=silent)
    found = {single.effects[-1].kind: single.chi_square for single in candidates[:2]}
    assert ended
    # equal physics: both fits end within their tolerance
    assert found["force_transducer_mass"] == pytest.approx(found["extra_mass"], rel=0.01)


def test_two_vain_starts_at_the_declared_values_are_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    predictor, _ = predicting(draw_measurement(rig(), [ExtraMass(Dof(6, "Y"), 0.05)]))
    base = fit(predictor, ())
    candidates, tried = module._Round(predictor, base, set()), list[Fit]()

    def begun(found: Fit, *, better: Sequence[str] = ()) -> bool:
        tried.append(found)
        return str(found.effects[0].at) in better

    def fit_at(node: int) -> Fit:
        return replace(
            base, effects=(ExtraMass(Dof(node, "Y")),), chi_square=(1 + node / 100) * base.chi_square
        )

    monkeypatch.setattr(candidates, "_fit_one_from_declared", begun)
    candidates.fits = [fit_at(node) for node in (10, 4, 8, 2, 6)]
    candidates._fit_from_declared()
    candidates._fit_from_declared()  # there is nothing new
    assert tried == [candidates.fits[3], candidates.fits[1]]  # the best ones

    monkeypatch.setattr(candidates, "_fit_one_from_declared", partial(begun, better=["3:+Y"]))
    candidates.fits += [fit_at(node) for node in (7, 5, 3)]
    candidates._fit_from_declared()
    assert tried[2:] == candidates.fits[:4:-1]  # one was better: two more


def test_an_error_of_all_members_is_fitted_though_many_single_ones_come_nearer_at_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    predictor, _ = predicting(draw_measurement(rig(), [LossFactorError(None, 1.5)]))
    suspects = [*(LossFactorError(Members((n,)), 2.0) for n in range(1, 7)), LossFactorError(None, 1.4)]

    def costs(_: object, __: object, effect: Effect, ___: float) -> tuple[Effect, float]:
        return effect, 1.5 if effect.at is None else 1.0

    monkeypatch.setattr(module, "scan", lambda *_: [StartingPoint(effect, 0.03) for effect in suspects])
    monkeypatch.setattr(module, "coarse_fit", costs)
    best, *_ = fit_candidates(predictor, fit(predictor, ()), Suspects(suspects), progress=silent)
    assert best.effects[-1].at is None
    assert best.effects[-1].parameters["factor"] == pytest.approx(1.5, rel=0.01)  # noise of 1e-3


@pytest.mark.parametrize(
    ("hidden", "approached"),
    [(StiffnessError(Members((3,)), 0.6), False), (GroundSpring(Dof(3, "Y"), 2e4), True)],
)
def test_an_unmeasured_nonlinear_force_rivals_only_what_its_linearisation_explains(
    hidden: Effect, approached: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    kinds: list[str] = []

    def recorded(*given: Any) -> tuple[Effect, float]:
        kinds.append(given[2].kind)
        return coarse_fit(*given)

    monkeypatch.setattr(module, "coarse_fit", recorded)
    predictor, _ = predicting(draw_measurement(rig(), [hidden]))
    elements = [StiffnessError(Members((number,))) for number in range(1, 9)]
    end_of_element_3 = Dof(3, "Y")  # without an accelerometer
    suspects = Suspects([*elements, GroundSpring(end_of_element_3), CubicStiffness(end_of_element_3)])
    best, *_ = fit_candidates(predictor, fit(predictor, ()), suspects, progress=silent)
    assert best.effects[-1].at == hidden.at
    assert ("cubic_stiffness" in kinds) is approached


def test_no_measured_nonlinear_force_rivals_an_explanation_of_the_whole_structure(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of 102 s for shear flexibility of all members 18 s went to forces at ten measured motions."""
    kinds: list[str] = []

    def recorded(*given: Any) -> tuple[Effect, float]:
        kinds.append(given[2].kind)
        return coarse_fit(*given)

    monkeypatch.setattr(module, "coarse_fit", recorded)
    hidden = StiffnessError(None, 1.05)
    predictor, _ = predicting(draw_measurement(rig(), [hidden]))
    suspects = Suspects([hidden, *(CubicStiffness(Dof(node, "Y")) for node in (4, 7))])
    best, *_ = fit_candidates(predictor, fit(predictor, ()), suspects, progress=silent)
    assert best.effects[-1].kind == "stiffness_error"
    assert "cubic_stiffness" not in kinds


def test_linearisations_at_all_places_are_scanned_together(monkeypatch: pytest.MonkeyPatch) -> None:
    scanned: list[set[str]] = []

    def recorded(*given: Any) -> list[StartingPoint]:
        scanned.append({effect.kind for effect in given[2]})
        return scan(*given)

    monkeypatch.setattr(module, "scan", recorded)
    hidden = StiffnessError(None, 1.05)
    predictor, _ = predicting(draw_measurement(rig(), [hidden]))
    measured = {channel.response.point for channel in predictor.observed.channels}
    unmeasured = [dof for dof in (Dof(node, "Y") for node in range(1, 10)) if dof not in measured]
    assert len(unmeasured) > 1
    suspects = Suspects([hidden, *map(CubicStiffness, unmeasured)])
    best, *_ = fit_candidates(predictor, fit(predictor, ()), suspects, progress=silent)
    assert best.effects[-1].kind == "stiffness_error"
    assert scanned.count({"ground_spring"}) == 1


@pytest.mark.parametrize("explained", [True, False])
def test_no_nonlinear_force_is_sought_beside_what_assumed_tolerances_explain(
    explained: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Stated tolerances leave more than random error of a model that is a little wrong everywhere."""
    scanned = recorded_scans(monkeypatch)
    hidden = StiffnessError(Members((3,)), 0.6)
    predictor, _ = predicting(draw_measurement(rig(), [StiffnessError(None, 1.005), hidden]))
    suspects = Suspects([hidden.with_parameters({"factor": 1.5}), CubicStiffness(Dof(7, "Y"))])
    asked: list[Fit] = []

    def explains(single: Fit) -> bool:
        asked.append(single)
        return explained

    best, *_ = fit_candidates(predictor, fit(predictor, ()), suspects, progress=silent, explains=explains)
    assert [single.effects[-1].at for single in asked] == [hidden.at]
    assert best.effects[-1].at == hidden.at
    assert ("cubic_stiffness" in scanned) is not explained


@pytest.mark.parametrize("near", [False, True])
def test_nonlinear_forces_are_left_to_tolerances_that_alone_come_nearer_the_data(
    near: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    scanned = recorded_scans(monkeypatch)
    predictor, _ = predicting(draw_measurement(rig(), [StiffnessError(None, 1.005)]))
    suspects = Suspects([StiffnessError(Members((3,)), 1.5), CubicStiffness(Dof(7, "Y"))])
    start = fit(predictor, ())
    limit = start.chi_square * (0.01 if near else 1.0)
    fit_candidates(predictor, start, suspects, progress=silent, chi_square_without=limit)
    assert ("cubic_stiffness" in scanned) is not near


def test_a_round_leaves_half_of_the_predictions_for_further_effects(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    predictor, _ = predicting(draw_measurement(rig(), [ExtraMass(Dof(6, "Y"), 0.1)]))
    predictor = replace(predictor, budget=PredictionBudget(1000))

    def costly(predictor: Predictor, effects: Sequence[Effect], **given: Any) -> Fit:
        predictor.budget.spend(200)
        return fit(predictor, effects, **given)

    monkeypatch.setattr(module, "fit", costly)
    suspects = Suspects([kind(Dof(node, "Y")) for node in range(1, 10) for kind in (ExtraMass, GroundSpring)])
    base = fit(predictor, ())
    before = predictor.budget.remaining
    fits = fit_candidates(predictor, base, suspects, progress=silent)
    assert fits[0].effects[-1].at == Dof(6, "Y"), "the likeliest are fitted first"
    assert 0.2 * before < predictor.budget.remaining < 0.5 * before
    assert not predictor.budget.exhausted


def test_optional_parameters_are_for_those_near_the_best_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    extended: list[Effect] = []

    def noted(_predictor: Predictor, candidate: Fit, _near: Fit) -> Fit:
        extended.append(candidate.effects[-1])
        return candidate

    monkeypatch.setattr(module, "with_optional_parameters", noted)
    predictor, _ = predicting(draw_measurement(rig(), [ExtraMass(Dof(5, "Y"), 0.1)]))
    suspects = Suspects([ExtraMass(Dof(node, "Y")) for node in (5, 9)])
    found = fit_candidates(predictor, fit(predictor, ()), suspects, progress=silent)
    assert len(found) == 2
    assert [effect.at for effect in extended] == [Dof(5, "Y")]


def test_a_third_start_is_not_tried_where_two_lead_to_the_same_high_cost(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hidden, other = ExtraMass(Dof(5, "Y"), 0.1), StiffnessError(None, 0.99)
    starts = [StartingPoint(effect, 0.03) for effect in (hidden, *(5 * [other]), *(3 * [hidden]))]
    monkeypatch.setattr(module, "scan", lambda *_: starts)
    tried: list[str] = []

    def recorded(*given: Any) -> tuple[Effect, float]:
        tried.append(given[2].kind)
        return coarse_fit(*given)

    monkeypatch.setattr(module, "coarse_fit", recorded)
    predictor, _ = predicting(draw_measurement(rig(), [hidden]))
    fit_candidates(predictor, fit(predictor, ()), Suspects([hidden, other]), progress=silent)
    assert tried.count("stiffness_error") == 2
    assert tried.count("extra_mass") == 4


def test_starts_that_differ_in_a_choice_are_all_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    hidden = ExtraMass(Dof(5, "Y"), 0.1)
    choices = [JointFlexibility(Dof(8, "RZ"), 1e-6, consistent_mass=mass) for mass in (1.0, 1.0, 0.0)]
    starts = [StartingPoint(effect, 0.03) for effect in (hidden, *choices)]
    monkeypatch.setattr(module, "scan", lambda *_: starts)
    tried: list[Effect] = []

    def recorded(*given: Any) -> tuple[Effect, float]:
        tried.append(given[2])
        return coarse_fit(*given)

    monkeypatch.setattr(module, "coarse_fit", recorded)
    predictor, _ = predicting(draw_measurement(rig(), [hidden]))
    fit_candidates(predictor, fit(predictor, ()), Suspects([hidden, choices[0]]), progress=silent)
    assert choices[2] in tried


def test_what_the_best_effect_tends_to_is_fitted_from_there(monkeypatch: pytest.MonkeyPatch) -> None:
    hidden = GroundSpring(Dof(6, "Y"), 2e5)
    predictor, _ = predicting(draw_measurement(rig(), [hidden]))
    heavy = AttachedOscillator(Dof(6, "Y"), 50.0, 10.0, 1e-4)
    starts = [StartingPoint(heavy, 0.03), StartingPoint(replace(hidden, stiffness=1e-3), 0.03)]
    monkeypatch.setattr(module, "scan", lambda *_: starts)
    monkeypatch.setattr(module, "coarse_fit", lambda _, __, effect, ___: (effect, 1.0))
    suspects = Suspects([AttachedOscillator(hidden.at), GroundSpring(hidden.at)])
    best, *_ = fit_candidates(predictor, fit(predictor, ()), suspects, progress=silent)
    assert best.effects[-1].kind == hidden.kind
    error = best.errors[-1]["stiffness"]
    assert abs(best.effects[-1].parameters["stiffness"] - 2e5) < 4 * error  # four standard errors


@pytest.mark.parametrize(("error", "kind"), [(5e5, "extra_mass"), (1e3, "attached_oscillator")])
def test_an_oscillator_of_undetermined_frequency_stands_for_no_more_than_its_mass(
    error: float, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside a model that is a little wrong its further parameters absorb what is none of theirs."""
    at = Dof(5, "Y")
    predictor, _ = predicting(draw_measurement(rig(), [ExtraMass(at, 0.1)]))
    starts = [StartingPoint(AttachedOscillator(at, 0.1, 9e5), 0.03)]

    def absorbing_fit(predictor: Predictor, effects: Sequence[Effect], **options: Any) -> Fit:
        found = fit(predictor, effects, **options)
        if found.effects[-1].kind == "extra_mass":
            return found
        errors = ParameterErrors(({**found.errors[-1], "frequency": error},), np.zeros((0, 0)), {})
        return replace(found, chi_square=0.992 * found.chi_square, compute_errors=lambda: errors)

    monkeypatch.setattr(module, "scan", lambda *_: starts)
    monkeypatch.setattr(module, "fit", absorbing_fit)
    suspects = Suspects([AttachedOscillator(at), ExtraMass(at)])
    best, *_ = fit_candidates(predictor, fit(predictor, ()), suspects, progress=silent)
    assert best.effects[-1].kind == kind


def test_beside_a_known_explanation_its_rivals_alone_are_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    hidden = ExtraMass(Dof(6, "Y"), 0.05)
    predictor, _ = predicting(draw_measurement(rig(), [hidden]))
    base = fit(predictor, ())
    known = fit(predictor, (hidden,), near=base)
    begun: list[str] = []

    def recorded(*given: Any, **options: Any) -> Fit:
        begun.append(str(given[1][-1].at))
        return fit(*given, **options)

    monkeypatch.setattr(module, "fit", recorded)
    suspects = Suspects([ExtraMass(Dof(node, "Y")) for node in range(1, 10)])
    found = fit_candidates(predictor, base, suspects, progress=silent, explanation=known)
    assert found[0] is known
    assert str(hidden.at) not in begun
    assert len(begun) == ROUND.min_fits - 1


def test_a_fit_far_above_the_best_one_is_given_up_after_a_few_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    hidden, other = ExtraMass(Dof(6, "Y"), 0.05), StiffnessError(Members((2,)), 0.9)
    starts = [StartingPoint(effect, 0.03) for effect in (hidden, other)]
    monkeypatch.setattr(module, "scan", lambda *_: starts)
    limits: dict[str, float] = {}

    def recorded(predictor: Predictor, effects: Sequence[Effect], **given: Any) -> Fit:
        limits.setdefault(effects[-1].kind, given.get("max_chi_square", np.inf))
        return fit(predictor, effects, **given)

    monkeypatch.setattr(module, "fit", recorded)
    predictor, _ = predicting(draw_measurement(rig(), [hidden]))
    best, *_ = fit_candidates(predictor, fit(predictor, ()), Suspects([hidden, other]), progress=silent)
    assert limits == {"extra_mass": np.inf, "stiffness_error": ROUND.limiting_cost * best.chi_square}


@pytest.mark.parametrize(("ratio", "n_restarted"), [(1 + ROUND.same_cost / 2, 0), (1.5, 1)])
def test_an_effect_is_not_fitted_from_a_third_start_where_two_end_alike(
    ratio: float, n_restarted: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    restarted: list[Fit] = []

    def noted(_predictor: Predictor, base: Fit, fits: Sequence[Fit]) -> list[Fit]:
        restarted.append(base)
        return list(fits)

    predictor, _ = predicting(draw_measurement(rig(), [ExtraMass(Dof(6, "Y"), 0.05)]))
    ordinary = Tolerances.preset(TolerancePreset.ORDINARY)
    predictor = predictor.with_nuisances(nuisance_parameters(ordinary, predictor.system, predictor.setup))
    base = fit(predictor, ())
    found = replace(base, effects=(ExtraMass(Dof(5, "Y")),), chi_square=100.0 * base.n_data)
    candidates = module._Round(predictor, base, set())
    candidates.fits = [found]
    monkeypatch.setattr(module, "with_best_from_base", noted)
    monkeypatch.setattr(module, "with_limiting_effects", lambda _, __, fits, ___: fits)
    monkeypatch.setattr(module, "fit", lambda *_, **__: replace(found, chi_square=ratio * found.chi_square))
    candidates._fit_one_from_declared(found)
    candidates.fit_limits_of_best()
    assert len(restarted) == n_restarted
