import math
import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels, Members
from modallab.diagnosis.reporting.figures import shown_channels
from modallab.diagnosis.reporting.report import report
from modallab.diagnosis.reporting.text import number_text
from modallab.diagnosis.result import (
    EquivalentEffect,
    FittedEffect,
    FittedParameter,
    NextTest,
    Rival,
    Step,
    ToleratedParameter,
    Verdict,
)
from modallab.diagnosis.result_localisation import ModeShift
from tests.diagnosed import STEP, curves, diagnosis


def text_of(page: str) -> str:
    """Return the words of a page, which must be well-formed."""
    return " ".join(" ".join(ET.fromstring(page).itertext()).split())


def test_the_page_says_what_was_missing_where_and_how_sure() -> None:
    words = text_of(report(diagnosis()))
    assert "Missing effect: extra mass at 4:+Y" in words
    assert "mass 0.03000 ± 0.00040 kg" in words
    assert "97.3 %" in words
    assert "from 812 to 1.04" in words
    assert "from 790 to 1.06" in words
    assert "density error at member 3" in words
    assert "118 to 126 Hz" in words
    assert "seed 17" in words


def test_the_next_test_and_those_that_were_done_are_told() -> None:
    test = NextTest(
        "a hammer leaves nothing behind", {"exciter": "hammer"}, ("extra_mass", "gain_error"), 12.3
    )
    done = ({"level_factor": 3.0}, {"added_mass": {"at": "5:+Y", "mass": 0.05}})
    made = {"structure_id": "s", "measurement_id": "m", "follow_up_1": "m1", "follow_up_2": "m2"}
    found = replace(diagnosis(Verdict.AMBIGUOUS), next_test=test, follow_ups=done)
    words = text_of(report(found, provenance=made))
    assert "Measure again with a hammer as the exciter: a hammer leaves nothing behind." in words
    assert "The expected difference is 12.3 standard deviations" in words
    assert "with 3 times the force level" in words
    assert "a known mass of 0.05 kg at 5:+Y" in words
    assert '{"measurement_id": "m1", "changed": {"level_factor": 3.0}}' in words


def test_the_page_needs_nothing_from_elsewhere() -> None:
    page = report(diagnosis())
    for word in ("http", "src=", "href=", "url(", "<script", "@import"):
        assert word not in page


def test_what_comes_from_outside_cannot_become_markup() -> None:
    test = NextTest("<b>more</b> averages & care", {"averages": "<10>"}, ("extra_mass",))
    noted = replace(diagnosis(Verdict.AMBIGUOUS), next_test=test, notes=("<script>alert(1)</script>",))
    page = report(noted)
    assert "<b>" not in page
    assert "<script" not in page
    assert "<b>more</b> averages & care" in text_of(page)


@pytest.mark.parametrize(
    ("verdict", "steps", "words"),
    [
        (Verdict.NOTHING_MISSING, (), "Nothing is missing that this test can show."),
        (
            Verdict.UNEXPLAINED,
            (),
            "Unexplained: no suspect accounts for the difference. Nothing is added to the model.",
        ),
        (
            Verdict.PARTLY_EXPLAINED,
            (replace(STEP, gap_before=801.0, gap_after=9.0),),
            "Partly explained: extra mass at 4:+Y closes most of the gap; what remains, 1 % of it,",
        ),
        (
            Verdict.UNEXPLAINED,
            (STEP,),
            "Unexplained: extra mass at 4:+Y reduces the gap, but may not be present",
        ),
        (
            Verdict.AMBIGUOUS,
            (replace(STEP, rivals_alike=(EquivalentEffect("density_error", Members((3,))),)),),
            "from density error at member 3",
        ),
    ],
)
def test_every_ending_is_said_in_plain_words(verdict: Verdict, steps: tuple[Step, ...], words: str) -> None:
    assert words in text_of(report(diagnosis(verdict, steps)))


def test_what_was_missing_is_claimed_only_where_it_explains_the_test() -> None:
    said = {one: text_of(report(diagnosis(one))) for one in (Verdict.EXPLAINED, Verdict.UNEXPLAINED)}
    assert "Missing effect" in said[Verdict.EXPLAINED]
    assert "Missing effect" not in said[Verdict.UNEXPLAINED]
    assert "Added effects" in said[Verdict.UNEXPLAINED]


def test_effects_of_later_rounds_are_shown_with_their_own_rivals() -> None:
    second = replace(
        STEP,
        effect=FittedEffect("leakage", None, {"share": FittedParameter(0.02, 0.001, "1")}),
        rivals=(Rival("response_noise", None, 0.02, 3.0),),
    )
    words = text_of(report(diagnosis(steps=(STEP, second))))
    assert "extra mass at 4:+Y and leakage." in words
    assert "response noise 2.0 % 3.00" in words


def test_what_a_low_probability_of_one_of_a_pair_means_is_said() -> None:
    second = replace(STEP, effect=FittedEffect("leakage", None, {"share": FittedParameter(0.02, 0.001, "1")}))
    pair = text_of(report(diagnosis(steps=(replace(STEP, probability=1e-9), second))))
    assert "it says nothing about the combination" in pair
    assert "it says nothing about" not in text_of(report(diagnosis(steps=(STEP, second))))


def test_shifts_of_modes_stand_in_a_table_and_further_tests_in_words() -> None:
    shifts = (ModeShift(1, 36.25, -0.0025, 0.00003, math.nan, math.nan),)
    found = diagnosis()
    words = text_of(
        report(
            replace(
                found,
                located=replace(found.located, mode_shifts=shifts),
                follow_ups=({"level_factor": 3.0},),
            )
        )
    )
    assert "1 36.25 -0.2500 ± 0.0030 % —" in words
    assert "explained together with it, with 3 times the force level." in words


def test_the_page_says_by_which_call_it_is_repeated() -> None:
    made = {"id": "d1", "version": "0.1.0", "structure_id": "s1", "measurement_id": "m1"}
    words = text_of(report(diagnosis(), made))
    assert 'POST /v1/diagnoses {"structure_id": "s1", "measurement_id": "m1", "seed": 17}' in words
    assert "diagnosis d1, by modallab 0.1.0." in words


def test_the_channels_shown_are_the_drive_point_the_worst_and_one_held_out() -> None:
    shown = shown_channels(curves())
    assert shown[0] == "drive point"
    assert shown[3] == "largest residual of the fitted responses"
    assert shown[2] == "largest residual of the held-out responses"


def test_a_response_that_was_not_measured_is_drawn_as_predicted() -> None:
    found = curves()
    unmeasured = replace(found, predicted=found.after[:, :1], predicted_outputs=(Dof(3, "Y"),))
    words = text_of(report(replace(diagnosis(), curves=unmeasured)))
    assert "Response 3:+Y / 1:+Y, not measured: prediction." in words


def test_a_page_of_many_lines_stays_small() -> None:
    # 60,001 lines drawn in full would take 9 MB; thinned, a curve has about 700 points
    assert len(report(replace(diagnosis(), curves=curves(60_001)))) < 500_000


@pytest.mark.parametrize(
    ("value", "error", "unit", "words"),
    [
        (1.3, 0.0004, "1", "1.30000 ± 0.00040"),
        (1.003e-4, 1.2e-6, "1", "(1.003 ± 0.012)·10⁻⁴"),
        (0.05, 0.0, "kg", "0.05 kg"),
        (3.239e11, 5.1e9, "N/m^3", "(3.239 ± 0.051)·10¹¹ N/m³"),
    ],
)
def test_a_number_has_the_digits_that_are_known(value: float, error: float, unit: str, words: str) -> None:
    assert number_text(FittedParameter(value, error, unit)) == words


def test_what_may_differ_a_little_stands_in_a_table_where_it_was_tolerated() -> None:
    tolerated = (
        ToleratedParameter("modal_loss_factor", 1.1834, 0.0021, 0.2, "1", mode=3),
        ToleratedParameter("delay", -1.2e-6, 2e-8, 1e-6, "s", at=Channels((Dof(4, "Y"),))),
    )
    words = text_of(report(replace(diagnosis(), tolerated=tolerated)))
    assert "loss factor of mode 3 1.1834 ± 0.0021 ± 20 %" in words
    assert "delay, channel 4:+Y (-1.200 ± 0.020)·10⁻⁶ s ± 1e-06 s" in words
    assert "Parameters within tolerances" not in text_of(report(diagnosis()))
    nothing = replace(diagnosis(Verdict.NOTHING_MISSING, ()), tolerated=tolerated)
    words = text_of(report(nothing))
    assert "Model and log book, within their tolerances, predict this test" in words
    assert "Differences within the tolerances What follows compares the test with model and log book" in words
    assert "Model and measurement agree" not in words
    assert "Model and measurement agree" in text_of(report(diagnosis(Verdict.NOTHING_MISSING, ())))


def test_of_members_that_share_a_tolerance_the_one_that_deviates_most_is_in_the_table() -> None:
    values = {1: 1.002, 2: 0.9917, 3: 1.004}
    tolerated = tuple(
        ToleratedParameter("modulus_variation", value, 0.0012, 0.005, "1", at=Members((number,)))
        for number, value in values.items()
    )
    words = text_of(report(replace(diagnosis(), tolerated=tolerated)))
    assert "modulus variation, member 2 (largest of 3) 0.9917 ± 0.0012 ± 0.5 %" in words
    assert "member 1 " not in words.split("Parameters within tolerances")[1]
