"""Tolerances that are assumed for an uploaded test."""

from collections.abc import Sequence
from dataclasses import replace
from types import ModuleType
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels, Members
from modallab.diagnosis import assumed_tolerances, measured_tests, search_task
from modallab.diagnosis.assumed_tolerances import refitted_path
from modallab.diagnosis.diagnose import diagnose_with_options
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.optimisation.tolerance_effects import MemberTolerance
from modallab.diagnosis.optimisation.tolerances import TolerancePreset, Tolerances
from modallab.diagnosis.options import DiagnosisOptions
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.result import Diagnosis, Verdict
from modallab.diagnosis.search_result import SearchResult
from modallab.diagnosis.searching import search_round
from modallab.diagnosis.searching.search import search
from modallab.diagnosis.searching.search_path import SearchPath
from modallab.effects.density_error import DensityError
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.gain_error import GainError
from modallab.effects.loss_factor_error import LossFactorError
from modallab.effects.stiffness_error import StiffnessError
from modallab.rig.effect import Effect
from modallab.rig.measure import Route
from tests.diagnosing import draw_measurement, model, rig

SUSPECTS = ("extra_mass", "stiffness_error", "gain_error")
N_MEMBERS = len(model().members)
# A model that is wrong everywhere, a little and smoothly: 0.5 % from one end to the other.
INEXACT = MemberTolerance(stiffness=tuple(np.linspace(0.995, 1.005, N_MEMBERS).tolist()))

# Deviations of a standard deviation and more along the whole structure, of modulus and density.
UNEVEN = MemberTolerance(
    stiffness=tuple((1 + 0.008 * np.cos(np.linspace(0, 3 * np.pi, N_MEMBERS))).tolist()),
    mass=tuple((1 + 0.008 * np.sin(np.linspace(0, 2 * np.pi, N_MEMBERS))).tolist()),
)


SLIGHTLY_UNEVEN = MemberTolerance(
    stiffness=tuple(1 + 0.4 * (factor - 1) for factor in UNEVEN.stiffness),
    mass=tuple(1 + 0.4 * (factor - 1) for factor in UNEVEN.mass),
)


def diagnosed(
    *hidden: Effect,
    uploaded: bool = True,
    preset: TolerancePreset | Tolerances | None = None,
    max_effects: int = 1,
    suspects: tuple[str, ...] = SUSPECTS,
) -> Diagnosis:
    test = draw_measurement(rig(), hidden)
    test = replace(test, route=None if uploaded else Route.DRAWN)
    options = DiagnosisOptions(suspects=suspects, tolerances=preset, max_effects=max_effects)
    return diagnose_with_options(model(), test, options)


def test_an_exact_model_needs_none() -> None:
    found = diagnosed(ExtraMass(Dof(4, "Y"), 0.02))
    assert found.verdict is Verdict.EXPLAINED
    assert found.steps[0].effect.at == Dof(4, "Y")
    assert not found.tolerated
    assert not any("assumed" in note for note in found.notes)


def test_a_model_that_is_a_little_wrong_everywhere_misses_nothing() -> None:
    found = diagnosed(INEXACT)
    assert found.verdict is Verdict.NOTHING_MISSING
    assert {row.name for row in found.tolerated} >= {"modulus", "modulus_variation", "modal_loss_factor"}
    (note,) = [note for note in found.notes if "assumed" in note]
    assert "modulus_variation 0.005" in note


def test_usual_deviations_of_random_fields_are_searched_for_no_effect(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("searched")

    monkeypatch.setattr(search_task, "fit_candidates", refuse)
    assert diagnosed(UNEVEN).verdict is Verdict.NOTHING_MISSING
    assert diagnosed(SLIGHTLY_UNEVEN).verdict is Verdict.NOTHING_MISSING
    with pytest.raises(AssertionError, match="searched"):
        diagnosed(StiffnessError(None, 1.042))


@pytest.mark.parametrize("true", [1.042, 0.98])
def test_an_effect_is_not_hidden_by_deviations_of_assumed_tolerances(true: float) -> None:
    """A modulus 4.2 % off is three and two standard deviations of modulus and density, or one effect.

    2 % are within the tolerance, but loss factors that are assumed within 20 % are right within 0.2 %: the
    modulus would be, too.
    """
    found = diagnosed(StiffnessError(None, true))
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == ("stiffness_error", None)
    factor = step.effect.parameters["factor"]
    assert abs(factor.value - true) < 4 * factor.standard_error  # four standard errors
    assert not found.tolerated


def test_a_deviation_within_an_assumed_tolerance_is_no_effect() -> None:
    """A modulus 0.7 % off beside others of their usual size."""
    found = diagnosed(UNEVEN, StiffnessError(None, 1.007))
    assert found.verdict is Verdict.NOTHING_MISSING
    assert found.tolerated


def test_an_effect_beside_it_is_named() -> None:
    found = diagnosed(INEXACT, StiffnessError(Members((3,)), 0.6))
    assert [step.effect.kind for step in found.steps] == ["stiffness_error"]
    assert found.steps[0].effect.at == Members((3,))
    factor = found.steps[0].effect.parameters["factor"]
    assert abs(factor.value - 0.6 * INEXACT.stiffness[2]) < 4 * factor.standard_error  # four standard errors


def test_effects_far_larger_than_the_tolerances_are_searched_once(monkeypatch: pytest.MonkeyPatch) -> None:
    nuisances = []

    def recorded(predictor: Predictor, *given: Any, **options: Any) -> SearchPath:
        nuisances.append(len(predictor.nuisances))
        return search(predictor, *given, **options)

    monkeypatch.setattr(search_task, "search", recorded)
    error, gain = StiffnessError(Members((3,)), 0.6), GainError(Channels((rig().responses[0],)), 1.4)
    found = diagnosed(INEXACT, error, gain, max_effects=2)
    assert found.verdict is Verdict.EXPLAINED
    assert {(step.effect.kind, step.effect.at) for step in found.steps} == {
        (error.kind, error.at),
        (gain.kind, gain.at),
    }
    assert found.tolerated
    assert set(nuisances) == {0}


def test_searches_under_both_tolerances_share_simulated_tests(monkeypatch: pytest.MonkeyPatch) -> None:
    predictors: list[Any] = []

    def recorded(predictor: Predictor, *given: Any, **options: Any) -> Fit:
        predictors.append(predictor)
        return fit(predictor, *given, **options)

    monkeypatch.setattr(measured_tests, "fit", recorded)
    diagnosed(INEXACT)
    assert len({len(predictor.nuisances) for predictor in predictors}) == 2  # of stated, of assumed ones
    assert len({id(predictor.simulated) for predictor in predictors}) == 1


def test_an_error_of_predictions_is_not_searched_under_assumed_tolerances(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A pair with a strong nonlinear force leaves more than random error, and took a second search."""
    monkeypatch.setattr(search_task, "is_prediction_error", lambda _, path: len(path.steps) > 1)
    error, gain = StiffnessError(Members((3,)), 0.6), GainError(Channels((rig().responses[0],)), 1.4)
    found = diagnosed(INEXACT, error, gain, max_effects=2)
    assert {step.effect.kind for step in found.steps} == {error.kind, gain.kind}
    assert not found.tolerated


def found_under_stated_tolerances_alone(
    predictor: Predictor, start: Fit, suspects: Any, **given: Any
) -> SearchPath:
    """A search that finds nothing where tolerances are free."""
    if len(predictor.nuisances):
        return SearchPath(start)
    return search(predictor, start, suspects, **given)


@pytest.mark.parametrize(
    ("module", "name", "value", "assumed"),
    [(search_task, "refitted_path", None, False), (assumed_tolerances, "_may_hide_effect", True, True)],
    ids=["under stated tolerances alone", "under both, which may hide an effect"],
)
def test_what_the_first_search_explains_is_kept_where_the_second_ends_worse(
    monkeypatch: pytest.MonkeyPatch, module: ModuleType, name: str, value: object, assumed: bool
) -> None:
    monkeypatch.setattr(search_task, "search", found_under_stated_tolerances_alone)
    monkeypatch.setattr(module, name, lambda *_: value)
    hidden = ExtraMass(Dof(4, "Y"), 0.2), GainError(Channels((Dof(5, "Y"),)), 1.3)
    found = diagnosed(*hidden, INEXACT, max_effects=2)
    assert {step.effect.kind for step in found.steps} == {"extra_mass", "gain_error"}
    assert (found.verdict is Verdict.EXPLAINED) is assumed
    assert any("assumed" in note for note in found.notes) is assumed


def test_a_mass_whose_fit_ends_elsewhere_is_not_named_an_oscillator(monkeypatch: pytest.MonkeyPatch) -> None:
    """An oscillator far above the band, which is a mass, was named with certainty."""

    def ended_elsewhere(predictor: Predictor, effects: Sequence[Effect], **given: Any) -> Fit:
        found = fit(predictor, effects, **given)
        of_mass = any(effect.kind == "extra_mass" for effect in effects)
        return replace(found, chi_square=found.chi_square + 30) if of_mass else found

    monkeypatch.setattr(assumed_tolerances, "fit", ended_elsewhere)
    found = diagnosed(ExtraMass(Dof(4, "Y"), 0.2), INEXACT, suspects=("extra_mass", "attached_oscillator"))
    assert [step.effect.kind for step in found.steps] == ["extra_mass"]


def test_rivals_of_what_is_kept_are_fitted_under_the_same_tolerances(monkeypatch: pytest.MonkeyPatch) -> None:
    """A further test was proposed from the nuisance parameters of the other tolerances, and failed."""
    kept: list[SearchPath] = []

    def recorded(path: SearchPath, second: SearchResult) -> SearchPath | None:
        refitted = refitted_path(path, second)
        assert refitted is not None
        kept.append(refitted)
        return refitted

    monkeypatch.setattr(search_task, "search", found_under_stated_tolerances_alone)
    monkeypatch.setattr(search_task, "refitted_path", recorded)
    diagnosed(ExtraMass(Dof(4, "Y"), 0.03), INEXACT)
    (step,) = kept[-1].steps
    assert step.kind_and_place == ("extra_mass", "4:+Y")
    n_nuisances = {len(each.nuisance_position) for each in (*step.round_fits, kept[-1].start)}
    assert len(n_nuisances) == 1
    assert n_nuisances != {0}


@pytest.mark.parametrize(("by_tolerances", "hidden"), [(9.0, False), (11.0, True)])
def test_tolerances_hide_an_effect_that_closes_less_than_ten_times_as_much(
    by_tolerances: float, hidden: bool
) -> None:
    under_stated, under_assumed, without_effect = (
        Mock(spec=Fit, chi_square=chi_square) for chi_square in (50.0 + by_tolerances, 50.0, 150.0)
    )
    assert assumed_tolerances._may_hide_effect(under_stated, under_assumed, without_effect) is hidden


def test_an_effect_as_small_as_the_tolerances_is_not_named() -> None:
    """A second effect of 0.6 % is within the variation of the modulus, 0.5 % for one standard deviation."""
    error = StiffnessError(Members((3,)), 0.6)
    found = diagnosed(INEXACT, error, StiffnessError(Members((7,)), 1.006), max_effects=2)
    assert found.verdict is Verdict.EXPLAINED
    assert [step.effect.at for step in found.steps] == [error.at]


@pytest.mark.parametrize("preset", [None, TolerancePreset.NONE])
def test_a_simulated_test_or_one_without_tolerances_has_none(preset: TolerancePreset | None) -> None:
    found = diagnosed(INEXACT, uploaded=preset is not None, preset=preset)
    assert found.verdict is not Verdict.NOTHING_MISSING
    assert not found.tolerated


def test_more_effects_have_to_leave_far_less_than_assumed_tolerances_do() -> None:
    def fitted(n_effects: int, chi_square: float) -> Fit:
        effects = tuple(ExtraMass(Dof(n, "Y"), 0.02) for n in range(1, n_effects + 1))
        return Mock(spec=Fit, effects=effects, chi_square=chi_square, n_data=1000)

    # A crack under assumed tolerances left an excess of 1,050 a thousand; two effects more, which imitated
    # the tolerances, left 1,000 without them.
    assert not assumed_tolerances.explains_more(fitted(3, 2000.0), fitted(1, 2050.0))
    assert assumed_tolerances.explains_more(fitted(3, 1400.0), fitted(1, 2050.0))
    # As many effects that leave less: the second search has missed one of them.
    assert assumed_tolerances.explains_more(fitted(2, 2000.0), fitted(3, 2050.0))
    assert not assumed_tolerances.explains_more(fitted(2, 2050.0), fitted(2, 2000.0))


def searched_with(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The numbers of nuisance parameters of the rounds of a search, filled as they begin."""
    numbers: list[int] = []
    fit_candidates = search_round.fit_candidates

    def recorded(predictor: Predictor, *given: Any, **options: Any) -> list[Fit]:
        numbers.append(len(predictor.nuisances))
        return fit_candidates(predictor, *given, **options)

    monkeypatch.setattr(search_task, "fit_candidates", recorded)
    return numbers


def test_where_assumed_tolerances_come_near_the_data_effects_beside_them_come_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A gain beside a model that is wrong everywhere: a round without tolerances took half of the time."""
    numbers = searched_with(monkeypatch)
    found = diagnosed(UNEVEN, GainError(Channels((Dof(9, "Y"),)), 1.01))
    assert found.verdict is Verdict.EXPLAINED
    assert [(step.effect.kind, str(step.effect.at)) for step in found.steps] == [
        ("gain_error", "channels 9:+Y")
    ]
    assert len(numbers) == 1
    assert numbers[0] > N_MEMBERS


@pytest.mark.parametrize("stated", [True, False])
def test_stated_tolerances_that_leave_far_more_than_assumed_ones_come_second(
    stated: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The assumed ones explain most of an uneven model, but of a gain of 4 % they come nowhere near."""
    numbers = searched_with(monkeypatch)
    tolerances = Tolerances(modulus=0.001) if stated else None
    found = diagnosed(UNEVEN, GainError(Channels((Dof(9, "Y"),)), 1.04), preset=tolerances)
    assert [step.effect.kind for step in found.steps] == ["gain_error"]
    assert (numbers[0] > N_MEMBERS) is stated


def test_an_effect_of_an_exact_model_that_they_nearly_explain_needs_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    numbers = searched_with(monkeypatch)
    found = diagnosed(StiffnessError(Members((4,)), 1.03))
    assert found.verdict is Verdict.EXPLAINED
    assert [(step.effect.kind, str(step.effect.at)) for step in found.steps] == [
        ("stiffness_error", "members 4")
    ]
    assert not found.tolerated
    assert numbers[0] > N_MEMBERS


def test_what_changes_spectra_alone_is_searched_for_where_one_effect_explains_the_frfs() -> None:
    """The search ended there: `partly_explained`, 27 of 32 of the gap of the force left."""
    hidden = ExtraMass(Dof(4, "Y"), 0.1), ExciterArmature(mass=0.06)
    found = diagnosed(*hidden, max_effects=2, suspects=(*SUSPECTS, "exciter_armature"))
    assert found.verdict is Verdict.EXPLAINED
    assert {step.effect.kind for step in found.steps} == {"extra_mass", "exciter_armature"}


def test_two_effects_of_an_exact_model_come_before_tolerances_that_deviate_as_far() -> None:
    """Density 3 % high was taken for modulus and density within 3 standard deviations of their tolerances."""
    hidden = LossFactorError(factor=0.6), DensityError(factor=1.03)
    found = diagnosed(*hidden, max_effects=3, suspects=("loss_factor_error", "density_error", "extra_mass"))
    assert found.verdict is Verdict.EXPLAINED
    assert {(step.effect.kind, step.effect.at) for step in found.steps} == {
        ("loss_factor_error", None),
        ("density_error", None),
    }


def test_tolerances_that_deviate_by_chance_are_not_searched_for_an_effect() -> None:
    hidden = LossFactorError(factor=0.4), StiffnessError(factor=1.01)  # one standard deviation
    found = diagnosed(*hidden, UNEVEN, max_effects=3, suspects=("loss_factor_error", "density_error"))
    assert [step.effect.kind for step in found.steps] == ["loss_factor_error"]
