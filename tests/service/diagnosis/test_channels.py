"""What is wrong with one channel shows in no other FRF, and is named all the same."""

import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.result import Verdict
from modallab.rig.effect import EFFECTS
from tests.diagnosing import draw_measurement, model, rig

HELD = [Dof(2, "Y")]
FAULTS = {
    "gain_error": {"factor": 1.05},
    "gain_error of a unit": {"factor": 1e3},
    "polarity": {},
    "channel_delay": {"delay": 3e-5},
    "mounted_resonance": {"frequency": 2e3},
    "misplaced_accelerometer": {"distance": -0.006},
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_one_channel_is_named_though_the_frfs_held_out_know_nothing_of_it(fault: str) -> None:
    kind, at, values = fault.split()[0], Channels((Dof(5, "Y"),)), FAULTS[fault]
    found = diagnose(
        model(), draw_measurement(rig(), [EFFECTS[kind](at=at, **values)]), suspects=[kind], hold_out=HELD
    )
    assert found.verdict is Verdict.EXPLAINED
    (step,) = found.steps
    assert (step.effect.kind, step.effect.at) == (kind, at)
    for name, value in values.items():
        number = step.effect.parameters[name]
        # four standard errors, one time in 16,000 beyond; of a distance also what a model solves to
        assert abs(number.value - value) < 4 * number.standard_error + 1e-6 * abs(value)


def test_noise_in_one_channel_is_no_fault_of_it() -> None:
    kinds = ["gain_error", "channel_delay", "misplaced_accelerometer", "ac_coupling"]
    found = diagnose(model(), draw_measurement(rig(), seed=3), suspects=kinds, hold_out=HELD)
    assert found.verdict is Verdict.NOTHING_MISSING
