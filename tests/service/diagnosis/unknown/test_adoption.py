"""An adopted effect in the model explains the test that showed it."""

from dataclasses import replace

import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.result import Verdict
from modallab.diagnosis.result_builder import extended
from modallab.diagnosis.unknown.adoption import adopted_effect
from modallab.effects.ac_coupling import AcCoupling
from modallab.effects.attached_oscillator import AttachedOscillator
from modallab.effects.ground_spring import GroundSpring
from modallab.rig.effect import Effect
from tests.diagnosing import draw_measurement, model, rig

HELD = [Dof(2, "Y")]


@pytest.mark.parametrize(
    ("hidden", "kind"),
    [
        (AttachedOscillator(at=Dof(5, "Y"), mass=0.05, frequency=120.0), "tabulated_stiffness"),
        (GroundSpring(at=Dof(5, "Y"), stiffness=2e4), "tabulated_stiffness"),
        (AcCoupling(at=Channels((Dof(5, "Y"),)), corner=20.0), "tabulated_response"),
    ],
)
def test_with_it_nothing_is_missing(hidden: Effect, kind: str) -> None:
    test = draw_measurement(rig(), [hidden])
    found = diagnose(model(), test, suspects=["polarity"], hold_out=HELD)
    assert found.unknown is not None
    effect = adopted_effect(found.unknown, found.curves.freq)
    assert effect.kind == kind
    structure, setup = extended(model(), test.setup, [effect])
    again = diagnose(structure, replace(test, setup=setup), suspects=["polarity"], hold_out=HELD)
    assert again.verdict is Verdict.NOTHING_MISSING
