"""Tests of a diagnosis by a model whose damping is unknown."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.result import Verdict
from modallab.effects.extra_mass import ExtraMass
from modallab.fe.damping import ModalDamping, UnknownDamping
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from tests.diagnosing import model, rig

LOSSES = (0.03, 0.004, 0.01, 0.002)  # of the modes below 400 Hz, factors 3 and 5 off 0.01


UNKNOWN = replace(model(), damping=UnknownDamping())
KINDS = ["extra_mass", "local_damping", "loss_factor_error", "damping_law"]


def measured(*hidden: ExtraMass) -> Measurement:
    true = replace(model(), damping=ModalDamping((*LOSSES, 0.01)))  # 0.01 above the band
    return measure(true, rig(), hidden, route=Route.DRAWN, rng=np.random.default_rng(2))


def test_the_loss_factor_of_each_mode_is_found() -> None:
    diagnosis = diagnose(UNKNOWN, measured(), suspects=KINDS)
    assert diagnosis.verdict is Verdict.NOTHING_MISSING
    found = {p.mode: p for p in diagnosis.tolerated if p.name == "modal_loss_factor"}
    for mode, loss in enumerate(LOSSES, 1):
        # the prior draws by less than a standard error
        bound = 5 * found[mode].standard_error * 0.01
        assert found[mode].value * 0.01 == pytest.approx(loss, abs=bound), mode


def test_an_effect_is_named_as_with_known_damping() -> None:
    hidden = ExtraMass(at=Dof.parse("4:+Y"), mass=0.05)
    diagnosis = diagnose(UNKNOWN, measured(hidden), suspects=KINDS)
    assert [(step.effect.kind, step.effect.at) for step in diagnosis.steps] == [("extra_mass", hidden.at)]
    (mass,) = diagnosis.steps[0].effect.parameters.values()
    assert mass.value == pytest.approx(0.05, abs=4 * mass.standard_error)
