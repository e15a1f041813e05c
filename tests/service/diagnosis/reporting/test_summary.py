"""A diagnosis told on a terminal."""

from dataclasses import replace

from modallab.core.dof import Dof
from modallab.diagnosis.reporting.settings import TERMINAL
from modallab.diagnosis.reporting.summary import summary
from modallab.diagnosis.result import EquivalentEffect, NextTest, Verdict
from tests.diagnosed import STEP, diagnosis


def test_a_terminal_is_told_what_where_how_large_how_sure_and_what_is_left() -> None:
    lines = summary(diagnosis()).splitlines()
    assert lines[0] == "Explained. Missing effect: extra mass at 4:+Y."
    assert "where      frequency bands: 118 to 126 Hz" in lines
    assert "missing 1  extra mass at 4:+Y: mass 0.03000 ± 0.00040 kg" in lines
    assert "certainty  probability 97.3 %" in lines
    assert any("812\N{NO-BREAK SPACE}→\N{NO-BREAK SPACE}1.04 on the fitted FRFs" in x for x in lines)
    assert max(map(len, lines)) <= TERMINAL.width


def test_look_alikes_and_the_test_that_would_tell_are_told() -> None:
    step = replace(
        STEP, rivals_alike=(EquivalentEffect("force_transducer_mass", None), EquivalentEffect("drift", None))
    )
    test = NextTest("it moves", {"drive": Dof(9, "Y")}, ("extra_mass", "drift"))
    words = summary(replace(diagnosis(Verdict.AMBIGUOUS, (step,)), next_test=test, notes=("noted",)))
    said = " ".join(words.split())
    assert (
        "rivals this measurement cannot distinguish it from force transducer mass or "
        "drift of the stiffness between runs" in said
    )
    assert "next test Measure again with the force at 9:+Y: it moves." in said
    assert "note noted" in said


def test_nothing_missing_is_told_in_two_lines_and_where_to_look() -> None:
    words = summary(diagnosis(Verdict.NOTHING_MISSING, ()))
    assert words.startswith("Nothing is missing that this test can show.\n")
    assert "missing 1" not in words
