import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnknownDofError
from modallab.core.place import Channels
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.predicting.held_out import select_held_out
from modallab.diagnosis.residuals.frf_selection import FrfSelection
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.gain_error import GainError
from modallab.effects.mains_hum import MainsHum
from modallab.effects.stiffness_error import StiffnessError
from modallab.rig.effect import Effect
from tests.diagnosing import draw_measurement, model, rig

FAULTY = Dof(5, "Y")
SEEDS = range(12)  # two of five channels each: without a rule all spare one with a chance of 0.6^12 = 0.2 %


@pytest.mark.parametrize("fault", [GainError(Channels((FAULTY,)), 1.05), MainsHum(Channels((FAULTY,)), 0.05)])
def test_a_channel_that_disagrees_alone_is_left_to_the_fit(fault: Effect) -> None:
    test = draw_measurement(rig(), [fault])
    for seed in SEEDS:
        held, _ = select_held_out(model(), test, 0.34, (), seed)
        assert len(held) == 2
        assert FrfSelection(FAULTY) not in held


def test_a_fault_of_one_channel_is_found_whatever_the_draw() -> None:
    test = draw_measurement(rig(), [GainError(Channels((FAULTY,)), 1.02)])
    found = [diagnose(model(), test, suspects=["gain_error", "extra_mass"], seed=seed) for seed in range(4)]
    assert {(one.steps[0].effect.kind, one.steps[0].effect.at) for one in found} == {
        ("gain_error", Channels((FAULTY,)))
    }


def test_a_fault_that_tolerated_errors_drown_is_left_to_the_fit_all_the_same() -> None:
    # A modulus one standard deviation off moves every resonance by 0.15 %: far more than 4 % of one gain.
    hidden = [StiffnessError(None, 1.003), GainError(Channels((FAULTY,)), 1.04)]
    test, allowed = draw_measurement(rig(), hidden), Tolerances(modulus=0.003, sensitivity=0.005)
    drawing = [
        seed for seed in SEEDS if FrfSelection(FAULTY) in select_held_out(model(), test, 0.34, (), seed)[0]
    ][:2]
    assert drawing, "it does not stand out at first"
    for seed in drawing:
        found = diagnose(
            model(),
            test,
            suspects=["gain_error", "extra_mass"],
            tolerances=allowed,
            hold_out_fraction=0.34,
            seed=seed,
        )
        (step,) = found.steps
        assert (step.effect.kind, step.effect.at) == ("gain_error", Channels((FAULTY,)))


def test_what_is_wrong_with_the_structure_leaves_the_draw_as_it_is() -> None:
    right, wrong = draw_measurement(rig()), draw_measurement(rig(), [ExtraMass(Dof(4, "Y"), 0.05)])
    draws = [select_held_out(model(), test, 0.34, (), seed)[0] for seed in SEEDS for test in (right, wrong)]
    assert draws[::2] == draws[1::2]
    assert len({dof for draw in draws for dof in draw}) == 5, "every channel but the drive point has its turn"


def test_what_is_named_is_held_out_even_if_it_disagrees() -> None:
    test = draw_measurement(rig(), [GainError(Channels((FAULTY,)), 1.5)])
    held, unmeasured = select_held_out(model(), test, 0.34, (FAULTY, Dof(3, "Y")), 0)
    assert FrfSelection(FAULTY) in held
    assert unmeasured == (Dof(3, "Y"),)


def test_a_share_out_of_bounds_and_an_unknown_response_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="half"):
        select_held_out(model(), draw_measurement(rig()), 0.6, (), 0)
    with pytest.raises(UnknownDofError):
        select_held_out(model(), draw_measurement(rig()), 0.25, (Dof(99, "Y"),), 0)
