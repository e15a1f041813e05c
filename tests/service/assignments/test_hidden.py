"""What is hidden from a student: drawn once for good, within its limits, and from a secret."""

import numpy as np

from modallab.assignments.drawing import Lot
from modallab.assignments.hidden import HiddenEffect, drawn_for
from modallab.core.dof import Dof
from modallab.core.place import EffectSpec

PLACES = (Dof(3, "Y"), Dof(7, "Y"), Dof(9, "Y"))
TEMPLATE = HiddenEffect("extra_mass", PLACES, {"mass": (0.02, 0.08)})


def test_a_student_keeps_the_effects_that_were_drawn() -> None:
    assert drawn_for([TEMPLATE], "secret", "ann") == drawn_for([TEMPLATE], "secret", "ann")


def test_a_fixed_effect_is_the_same_for_everybody() -> None:
    fixed = HiddenEffect("extra_mass", (PLACES[1],), {"mass": (0.05, 0.05)})
    expected = (EffectSpec("extra_mass", PLACES[1], {"mass": 0.05}),)
    assert {drawn_for([fixed], "secret", name)[0].parameters["mass"] for name in "abc"} == {0.05}
    assert drawn_for([fixed], "other", "ann") == expected


def test_students_and_secrets_have_effects_of_their_own() -> None:
    drawn = [drawn_for([TEMPLATE], secret, name) for secret in ("one", "two") for name in "abc"]
    assert len({effects[0].parameters["mass"] for effects in drawn}) == 6


def test_draws_are_uniform_within_their_limits() -> None:
    effects = [drawn_for([TEMPLATE], "secret", str(number))[0] for number in range(3000)]
    masses = np.array([effect.parameters["mass"] for effect in effects])
    assert masses.min() >= 0.02
    assert masses.max() < 0.08
    # the mean of 3000 uniform numbers scatters by 0.06 / sqrt(12 x 3000) = 3.2e-4: four of them
    assert abs(masses.mean() - 0.05) < 1.3e-3
    shares = [sum(effect.at == place for effect in effects) / 3000 for place in PLACES]
    # a share of a third scatters by sqrt(2/9/3000) = 0.0086
    assert all(abs(share - 1 / 3) < 0.035 for share in shares)


def test_the_extremes_are_at_every_place() -> None:
    extremes = TEMPLATE.extremes()
    assert {effect.at for effect in extremes} == set(PLACES)
    assert {effect.parameters["mass"] for effect in extremes} == {0.02, 0.08}


def test_seeds_are_in_the_range_that_seeds_have_and_never_repeat() -> None:
    seeds = [Lot("secret", name).integer(index) for name in ("a", "b") for index in range(200)]
    assert len(set(seeds)) == 400
    assert all(0 <= seed < 2**63 for seed in seeds)
