"""A diagnosis told on a terminal."""

from dataclasses import replace

from modallab.core.dof import Dof
from modallab.diagnosis.reporting.summary import WIDTH, summary
from modallab.diagnosis.result import EquivalentEffect, NextTest, Verdict
from tests.diagnosed import STEP, diagnosis


def test_a_terminal_is_told_what_where_how_large_how_sure_and_what_is_left() -> None:
    lines = summary(diagnosis()).splitlines()
    assert lines[0] == "Explained. What was missing: extra mass at 4:+Y."
    assert "where      at 118 to 126 Hz" in lines
    assert "missing 1  extra mass at 4:+Y: mass 0.03000 ± 0.00040 kg" in lines
    assert "sure       97.3 % of the belief" in lines
    assert any(
        "812\N{NO-BREAK SPACE}→\N{NO-BREAK SPACE}1.04 on the FRFs that were fitted" in x for x in lines
    )
    assert max(map(len, lines)) <= WIDTH


def test_look_alikes_and_the_test_that_would_tell_are_told() -> None:
    step = replace(
        STEP, rivals_alike=(EquivalentEffect("force_transducer_mass", None), EquivalentEffect("drift", None))
    )
    test = NextTest("it moves", {"drive": Dof(9, "Y")}, ("extra_mass", "drift"))
    words = summary(replace(diagnosis(Verdict.AMBIGUOUS, (step,)), next_test=test, notes=("noted",)))
    said = " ".join(words.split())
    assert "alike this measurement cannot tell it from force transducer mass or drift everywhere" in said
    assert "next test Measure again with the force at 9:+Y: it moves." in said
    assert "note noted" in said


def test_nothing_missing_is_told_in_two_lines_and_where_to_look() -> None:
    words = summary(diagnosis(Verdict.NOTHING_MISSING, ()))
    assert words.startswith("Nothing is missing.\n")
    assert "missing 1" not in words
