import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.core.progress import silent
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.optimisation.nuisance_parameters import nuisance_parameters
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.result import Verdict
from modallab.diagnosis.searching import wrong_elements as elements
from modallab.diagnosis.searching.backward_elimination import Group
from modallab.diagnosis.searching.multiple_elements import multiple_elements
from modallab.diagnosis.searching.suspects import Suspects, suspected
from modallab.diagnosis.searching.wrong_elements import wrong_elements
from modallab.effects.accelerometer_mass import AccelerometerMass
from modallab.effects.density_error import DensityError
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.ground_spring import GroundSpring
from modallab.effects.loss_factor_error import LossFactorError
from modallab.effects.stiffness_error import StiffnessError
from modallab.rig.effect import Effect
from modallab.rig.measurement import Measurement
from tests.diagnosing import draw_measurement, model, predicting, rig

FOUR = [DensityError(at=Members((1, 2)), factor=2.0), StiffnessError(at=Members((5, 6)), factor=1.8)]


def named(effects: list[Effect]) -> set[tuple[str, str]]:
    return {(effect.kind, str(effect.at)) for effect in effects}


def found_in(measurement: Measurement) -> tuple[Effect, ...]:
    predictor, _ = predicting(measurement)
    return wrong_elements(predictor, suspected(predictor, None), silent)


@pytest.mark.parametrize(
    "hidden",
    [
        FOUR,
        [StiffnessError(at=Members((2,)), factor=0.5), StiffnessError(at=Members((7,)), factor=2.5)],
        [
            StiffnessError(at=Members((3,)), factor=0.7),
            DensityError(at=Members((3,)), factor=1.5),
            LossFactorError(at=Members((6,)), factor=4.0),
        ],
    ],
    ids=["neighbours", "far apart", "mass, stiffness and loss"],
)
def test_wrong_elements_are_found_together_and_nothing_else_is(hidden: list[Effect]) -> None:
    found = found_in(draw_measurement(rig(), hidden))
    assert named(list(found)) == named(hidden)
    true = {(effect.kind, str(effect.at)): effect.parameters["factor"] for effect in hidden}
    for effect in found:
        # Every other line, one straight line at the end: far less than what a fit goes on from.
        assert effect.parameters["factor"] == pytest.approx(true[effect.kind, str(effect.at)], rel=0.02)


def test_wrong_elements_are_found_in_leaking_data() -> None:
    assert named(list(found_in(draw_measurement(rig(kind="random", window="hann"), FOUR)))) == named(FOUR)


def test_wrong_elements_are_found_beside_what_may_differ_a_little() -> None:
    few = Tolerances(accelerometer_mass=0.03, delay=1e-6)
    heavier = AccelerometerMass(mass=0.0006)  # 3 % of the 20 g declared
    predictor, _ = predicting(draw_measurement(rig(), [heavier, *FOUR]))
    predictor = predictor.with_nuisances(nuisance_parameters(few, predictor.system, predictor.setup))
    found = wrong_elements(predictor, suspected(predictor, None), silent)
    assert named(list(found)) == named(FOUR)


def test_no_element_is_blamed_for_what_hangs_on_the_structure() -> None:
    # Springs to the ground at both ends: no factor of a free beam's members makes it bounce on them.
    springs = [GroundSpring(at=Dof(n, "Y"), stiffness=2e4) for n in (2, 8)]
    assert found_in(draw_measurement(rig(), springs)) == ()


def test_without_suspects_at_members_none_is_found() -> None:
    predictor, _ = predicting(draw_measurement(rig(), FOUR))
    assert wrong_elements(predictor, suspected(predictor, ["extra_mass", "polarity"]), silent) == ()


def test_a_factor_that_a_straight_line_takes_out_of_bounds_stays_within(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    beyond = [Group((0,), 50.0), Group((9,), -50.0)]
    monkeypatch.setattr(elements, "backward_elimination", lambda *_: beyond)
    found = found_in(draw_measurement(rig(), FOUR))
    bounds = [next(iter(effect.specs().values())) for effect in found]
    for effect, spec in zip(found, bounds, strict=True):
        assert spec.lower <= effect.parameters["factor"] <= spec.upper


def test_small_changes_of_many_members_are_no_explanation() -> None:
    slight = [StiffnessError(at=Members((n,)), factor=f) for n, f in ((2, 1.3), (5, 1.01), (7, 0.7))]
    large = [slight[0], StiffnessError(at=Members((5,)), factor=1.2), slight[2]]
    for hidden, accepted in ((slight, False), (large, True)):
        predictor, _ = predicting(draw_measurement(rig(), hidden))
        suspects = Suspects(suspected(predictor, ["stiffness_error"]))
        start = fit(predictor, ())
        found = multiple_elements(predictor, start, suspects, max_effects=4, progress=silent)
        assert (found is not None) == accepted
        assert multiple_elements(predictor, start, suspects, max_effects=2, progress=silent) is None


def test_several_wrong_elements_are_one_diagnosis_with_places() -> None:
    found = diagnose(
        model(), draw_measurement(rig(), FOUR), suspects=["stiffness_error", "density_error", "extra_mass"]
    )
    assert found.verdict is Verdict.EXPLAINED
    assert {(step.effect.kind, step.effect.at) for step in found.steps} == {(e.kind, e.at) for e in FOUR}
    true = {effect.kind: effect.parameters["factor"] for effect in FOUR}
    for step in found.steps:
        factor = step.effect.parameters["factor"]
        assert abs(factor.value - true[step.effect.kind]) < 4 * factor.standard_error
        assert step.probability > 0.99
        assert step.rivals  # what else might stand there was tried
    assert abs(found.remaining_gap - 1) < 4 * found.remaining_scatter
    members = {member.number: member for member in found.structure.members}
    assert [members[n].mass_factor for n in (1, 2, 3)] == pytest.approx([2.0, 2.0, 1.0], rel=0.01)
    assert [members[n].bending_factor for n in (5, 6, 7)] == pytest.approx([1.8, 1.8, 1.0], rel=0.01)


def test_a_mass_beside_a_wrong_element_does_not_become_wrong_elements() -> None:
    hidden = [ExtraMass(at=Dof(5, "Y"), mass=0.03), StiffnessError(at=Members((2,)), factor=1.3)]
    found = diagnose(
        model(), draw_measurement(rig(), hidden), suspects=["stiffness_error", "density_error", "extra_mass"]
    )
    assert {(s.effect.kind, s.effect.at) for s in found.steps} == {(e.kind, e.at) for e in hidden}


def test_effects_in_the_matrices_predict_what_they_do_beside_them() -> None:
    predictor, _ = predicting(draw_measurement(rig()))
    built, beside = predictor.folded_into_matrices(FOUR).predict(()), predictor.predict(FOUR)
    # Both are exact; the matrices' eigenvalues over 1e10 rad^2/s^2 leave this much to rounding.
    np.testing.assert_allclose(built.h, beside.h, rtol=1e-6)
    assert fit(predictor.folded_into_matrices(FOUR), ()).residual.frf.shape == predictor.observed.h.shape
