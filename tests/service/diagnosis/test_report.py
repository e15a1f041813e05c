import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.diagnosis.figures import telling
from modallab.diagnosis.report import report
from modallab.diagnosis.result import (
    Alias,
    Curves,
    Diagnosis,
    FittedEffect,
    FittedParameter,
    Located,
    NextTest,
    Rival,
    Step,
    Verdict,
)
from modallab.diagnosis.wording import number
from tests.diagnosing import model, rig

OUTPUTS = tuple(Dof(n, "Y") for n in (1, 2, 4, 5, 7, 9))
STEP = Step(
    effect=FittedEffect("extra_mass", Dof(4, "Y"), {"mass": FittedParameter(0.03, 0.0004, "kg")}),
    probability=0.9731,
    gap_before=812.0,
    gap_after=1.04,
    held_out_gap_before=790.0,
    held_out_gap_after=1.06,
    held_out_scatter=0.05,
)


def curves(n_freq: int = 60) -> Curves:
    """Return resonances that were predicted 3 % too high, and after an addition as they are."""
    freq = np.linspace(0.0, 400.0, n_freq)

    def frf(resonance: float) -> ComplexArray:
        one = -(freq**2) / (resonance**2 * (1 + 0.01j) - freq**2)
        return np.asarray(one[:, None, None] * np.arange(1.0, 7.0)[:, None], complex)

    measured = frf(120.0)
    measured[:, 3] *= 1.5  # the channel that is furthest off
    return Curves(
        freq=freq,
        measured=measured,
        before=frf(123.6),
        after=frf(120.0),
        random_error=np.full(measured.shape, 0.01),
        held_out=np.array([False, False, True, False, False, False]),
        outputs=OUTPUTS,
        inputs=(Dof(1, "Y"),),
    )


def diagnosis(verdict: Verdict = Verdict.EXPLAINED, steps: tuple[Step, ...] = (STEP,)) -> Diagnosis:
    """Return a diagnosis as the search would hand it over."""
    rivals = (
        Rival("extra_mass", Dof(4, "Y"), 0.9731, 1.04),
        Rival("density_error", Members((3,)), 0.0269, 1.31),
    )
    return Diagnosis(
        verdict=verdict,
        located=Located(((118.0, 126.0),), (Dof(5, "Y"),), (2,), ("frequency shifts: mode 2 -3.00 %",)),
        steps=steps,
        remaining_gap=1.05,
        remaining_scatter=0.02,
        gaps={"before": {"frf": 1500.0, "force": 130.0}, "after": {"frf": 1.08, "force": 1.02}},
        structure=model(),
        setup=rig(),
        curves=curves(),
        candidates=rivals if steps else (),
        seed=17,
    )


def text_of(page: str) -> str:
    """Return the words of a page, which must be well-formed."""
    return " ".join(" ".join(ET.fromstring(page).itertext()).split())


def test_the_page_says_what_was_missing_where_and_how_sure() -> None:
    words = text_of(report(diagnosis()))
    assert "What was missing: extra mass at 4:+Y" in words
    assert "mass 0.03000 ± 0.00040 kg" in words
    assert "97.3 %" in words
    assert "from 812 to 1.04" in words
    assert "from 790 to 1.06" in words
    assert "density error at member 3" in words
    assert "118 to 126 Hz" in words
    assert "seed 17" in words


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
        (Verdict.NOTHING_MISSING, (), "Nothing is missing."),
        (Verdict.UNEXPLAINED, (), "Unexplained: no suspect accounts for the difference."),
        (Verdict.UNEXPLAINED, (STEP,), "something else is left"),
        (
            Verdict.AMBIGUOUS,
            (replace(STEP, rivals_alike=(Alias("density_error", Members((3,))),)),),
            "cannot tell it from density error at member 3",
        ),
    ],
)
def test_every_ending_is_said_in_plain_words(verdict: Verdict, steps: tuple[Step, ...], words: str) -> None:
    assert words in text_of(report(diagnosis(verdict, steps)))


def test_effects_of_later_rounds_are_shown_with_their_own_rivals() -> None:
    second = replace(
        STEP,
        effect=FittedEffect("leakage", None, {"share": FittedParameter(0.02, 0.001, "1")}),
        rivals=(Rival("response_noise", None, 0.02, 3.0),),
    )
    words = text_of(report(diagnosis(steps=(STEP, second))))
    assert "extra mass at 4:+Y and leakage." in words
    assert "response noise 2.0 % 3.00" in words


def test_the_channels_shown_are_the_drive_point_the_worst_and_one_held_out() -> None:
    shown = telling(curves())
    assert shown[0] == "drive point"
    assert shown[3] == "worst of the fitted"
    assert shown[2] == "held out of every fit"


def test_a_response_that_was_not_measured_is_drawn_as_predicted() -> None:
    found = curves()
    unmeasured = replace(found, predicted=found.after[:, :1], predicted_outputs=(Dof(3, "Y"),))
    words = text_of(report(replace(diagnosis(), curves=unmeasured)))
    assert "Response 3:+Y / 1:+Y, not measured: predicted." in words


def test_a_page_of_many_lines_stays_small() -> None:
    # 60,001 lines drawn in full would take 9 MB; thinned, a curve has about 700 points
    assert len(report(replace(diagnosis(), curves=curves(60_001)))) < 500_000


@pytest.mark.parametrize(
    ("value", "error", "unit", "words"),
    [
        (1.3, 0.0004, "1", "1.30000 ± 0.00040"),
        (1.003e-4, 1.2e-6, "1", "(1.003 ± 0.012)·10^-4"),
        (0.05, 0.0, "kg", "0.05 kg"),
    ],
)
def test_a_number_has_the_digits_that_are_known(value: float, error: float, unit: str, words: str) -> None:
    assert number(FittedParameter(value, error, unit)) == words
