"""Measured tests: which of their FRFs are held out."""

import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.predicting.held_out import select_held_out
from modallab.diagnosis.result import Diagnosis, Verdict
from modallab.effects.gain_error import GainError
from modallab.effects.stiffness_error import StiffnessError
from tests.diagnosing import draw_measurement, model, rig

SUSPECTS = ("stiffness_error", "gain_error", "extra_mass")
STIFFER = StiffnessError(None, 1.06)


@pytest.fixture(scope="module")
def held_out() -> Dof:
    """The response that a diagnosis of a stiffer beam holds out by chance."""
    ((selection,), _) = select_held_out(model(), draw_measurement(rig(), [STIFFER]), 0.25, (), 0)
    assert selection.response is not None
    return selection.response


def diagnosed(wrong: Dof, *hold_out: Dof) -> Diagnosis:
    test = draw_measurement(rig(), [STIFFER, GainError(Channels((wrong,)), 1.1)])
    return diagnose(model(), test, suspects=SUSPECTS, hold_out=list(hold_out), seed=0)


def test_a_wrong_channel_that_was_held_out_beside_a_larger_effect_is_named(held_out: Dof) -> None:
    """Before the larger one was found its FRF differed no more than the others: `partly_explained`."""
    found = diagnosed(held_out)
    assert found.verdict is Verdict.EXPLAINED
    assert [(step.effect.kind, str(step.effect.at)) for step in found.steps] == [
        ("stiffness_error", "None"),
        ("gain_error", f"channels {held_out}"),
    ]
    assert found.curves.held_out.any(), "another one is held out in its place"


def test_what_the_user_holds_out_stays_so(held_out: Dof) -> None:
    found = diagnosed(held_out, held_out)
    assert [step.effect.kind for step in found.steps] == ["stiffness_error"]
    assert found.verdict is not Verdict.EXPLAINED
