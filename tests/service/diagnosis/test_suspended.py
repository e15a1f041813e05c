"""Tests of a diagnosis of a structure that hangs on two elastic bands which the log book forgot."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Dofs
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.reporting.text import effect_name, place_description
from modallab.diagnosis.result import Verdict
from modallab.effects.suspension import SuspensionStiffness
from modallab.rig.measure import Route, measure
from tests.diagnosing import model, rig

BANDS = Dofs((Dof.parse("2:+Y"), Dof.parse("8:+Y")))
HIDDEN = SuspensionStiffness(at=BANDS, stiffness=3000.0, loss_factor=0.05)


def test_two_equal_bands_are_named_as_one_suspension() -> None:
    test = measure(model(), rig(), [HIDDEN], route=Route.DRAWN, rng=np.random.default_rng(3))
    kinds = ["suspension", "ground_spring", "extra_mass", "gain_error"]
    diagnosis = diagnose(model(), test, suspects=kinds)
    assert diagnosis.verdict is Verdict.EXPLAINED
    (step,) = diagnosis.steps
    assert (step.effect.kind, step.effect.at) == ("suspension", BANDS)
    stiffness = step.effect.parameters["stiffness"]
    assert stiffness.value == pytest.approx(3000.0, abs=4 * stiffness.standard_error)
    assert effect_name(step.effect) == "suspension at 2:+Y and 8:+Y"
    assert place_description(BANDS, model()).count("; ") == 3  # two nodes, each with its members
