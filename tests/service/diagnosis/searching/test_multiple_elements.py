"""Rivals of several wrong elements: effects with one fitted parameter."""

from collections.abc import Sequence
from unittest.mock import Mock

import pytest

from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.core.progress import silent
from modallab.diagnosis.fitting.fit import Fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching import multiple_elements
from modallab.diagnosis.searching.suspects import Suspects
from modallab.effects.attached_oscillator import AttachedOscillator
from modallab.effects.joint_flexibility import JointFlexibility
from modallab.effects.stiffness_error import StiffnessError


def test_a_joint_is_a_rival_of_an_element_and_an_oscillator_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    soft = StiffnessError(Members((3,)), 0.8), StiffnessError(Members((6,)), 0.8)
    crack, oscillator = JointFlexibility(Dof(4, "RZ")), AttachedOscillator(Dof(4, "Y"))
    asked: list[Suspects] = []

    def candidates(_predictor: Predictor, _base: Fit, suspects: Suspects, **_given: object) -> Sequence[Fit]:
        asked.append(suspects)
        return []

    monkeypatch.setattr(multiple_elements, "fit_candidates", candidates)
    monkeypatch.setattr(multiple_elements, "fit", lambda *_given: Mock(spec=Fit))
    start, elements = Mock(spec=Fit), Mock(spec=Fit, effects=soft, nuisance_position=None)
    suspects = Suspects((*soft, crack, oscillator))
    path = multiple_elements.verify(Mock(), start, elements, suspects, silent)
    assert len(path.steps) == 2
    assert all(crack in simple.effects and oscillator not in simple.effects for simple in asked)
