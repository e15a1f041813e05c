"""What is said of effects, places, numbers and further tests."""

import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels, Members, Place
from modallab.diagnosis.reporting import text
from modallab.diagnosis.result import EquivalentEffect, NextTest, Rival, Step
from modallab.diagnosis.result_localisation import Localisation
from tests.diagnosed import STEP
from tests.diagnosing import model
from tests.rigs import dofs


@pytest.mark.parametrize(
    ("kind", "at", "words"),
    [
        ("stiffness_error", None, "stiffness error everywhere"),
        ("damping_law", None, "damping of another law than modelled"),
        ("exciter_armature", None, "exciter armature"),
        ("stinger_axial", None, "axial flexibility of the stinger"),
        ("stinger_bending", Dof(4, "Y"), "bending stiffness of the stinger at 4:+Y"),
        ("extra_mass", Dof(4, "Y"), "extra mass at 4:+Y"),
        ("density_error", Members((3,)), "density error at member 3"),
        ("density_error", Members((3, 4)), "density error at members 3 and 4"),
        ("polarity", Channels((Dof(7, "Y"),)), "polarity of channel 7:+Y"),
        ("swapped_channels", Channels((Dof(5, "Y"), Dof(7, "Y"))), "swapped channels 5:+Y and 7:+Y"),
        ("overload", Channels(dofs(1, 3, 5, 7, 9)), "overload of 5 channels, 1:+Y to 9:+Y"),
    ],
)
def test_an_effect_is_named_with_its_place(kind: str, at: Place, words: str) -> None:
    assert text.effect_name(EquivalentEffect(kind, at)) == words


@pytest.mark.parametrize(
    ("at", "words"),
    [
        (Dof(4, "Y"), "node 4, in Y; between members 3 and 4"),
        (Dof(4, "RZ"), "node 4, in rotation Z; between members 3 and 4"),
        (Dof(1, "Y"), "node 1, in Y; the end of member 1"),
        (Members((3,)), "member 3, between nodes 3 and 4"),
        (Channels((Dof(7, "Y"),)), "channel 7:+Y"),
        (None, "everywhere"),
    ],
)
def test_a_place_is_pointed_at(at: Place, words: str) -> None:
    assert text.place_description(at, model()) == words


def test_a_gap_keeps_its_three_digits() -> None:
    assert [text.gap_text(x) for x in (9687.4, 812.3, 11.53, 1.043)] == ["9,687", "812", "11.5", "1.04"]


def test_a_probability_never_claims_to_be_certain() -> None:
    assert [text.probability_text(x) for x in (1.0, 0.973, 1e-9)] == ["> 99.9 %", "97.3 %", "< 0.1 %"]


def test_sureness_names_the_next_best_and_what_it_leaves() -> None:
    rivals = (Rival("extra_mass", Dof(4, "Y"), 0.97, 1.04), Rival("drift", None, 0.03, 31.0))
    step = Step(**{**vars(STEP), "rivals": rivals})
    words = (
        "probability 97.3 %; next best: drift of the stiffness between runs, 3.0 %, "
        "with a remaining gap of 31"
    )
    assert text.probability_statement(step) == words


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"level_factor": 3.0}, "3 times the force level"),
        ({"drive": "9:+Y"}, "the force at 9:+Y"),
        ({"exciter": "hammer"}, "a hammer as the exciter"),
        ({"responses": ["1:+Y", "3:+Y"]}, "responses at 1:+Y and 3:+Y"),
        ({"added_mass": {"mass": 0.05, "at": "sensors"}}, "a known mass of 0.05 kg on every sensor"),
        ({"added_mass": {"mass": 0.05, "at": "1:+Y"}}, "a known mass of 0.05 kg at 1:+Y"),
        ({"excitation": "periodic_random", "window": "hann"}, "periodic random excitation and a hann window"),
        ({"weather": "dry"}, "weather dry"),
    ],
)
def test_a_further_test_is_told_by_what_it_changes(change: dict[str, object], words: str) -> None:
    told = text.next_test_text(NextTest("because", change, ("extra_mass", "force_transducer_mass")))
    assert (
        told == f"Measure again with {words}: because. It distinguishes extra mass and force transducer mass."
    )


def test_a_shift_is_told_in_per_cent_with_the_digits_that_are_known() -> None:
    assert text.shift_text(-0.00252, 0.00003) == "-0.2520 ± 0.0030 %"
    assert text.shift_text(float("nan"), float("nan")) == "\N{EM DASH}"


def test_what_is_said_of_bands_modes_and_responses_is_said_once() -> None:
    repeated = ("bands: 20 to 24 Hz", "responses: 5:+Y", "mean squared residual: FRFs 30")
    found = Localisation(((20.0, 24.0), (31.0, 31.0)), (Dof(5, "Y"),), (1, 2), (*repeated, "mode 1 is lower"))
    assert text.location_statements(found) == [
        "frequency bands: 20 to 24 Hz and 31 Hz",
        "elastic modes of the model: 1 and 2",
        "responses that disagree most: 5:+Y",
        "mode 1 is lower",
    ]
