from dataclasses import replace
from typing import Any

import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.place import Channels, EffectSpec
from modallab.effects.accelerometer_mass import AccelerometerMass
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.force_transducer_mass import ForceTransducerMass
from modallab.effects.gain_error import GainError
from modallab.effects.stinger_bending import StingerBending
from modallab.effects.swapped_channels import SwappedChannels
from modallab.rig.change import Change
from modallab.rig.effect import Effect
from modallab.rig.effects_in_other_test import effects_in_other_test
from tests.diagnosing import rig

CHANGES: list[dict[str, Any]] = [
    {"level_factor": 3.0},
    {"averages_factor": 10.0},
    {"n_lines": 321},
    {"frequency_max": 800.0, "n_lines": 321},
    {"window": "hann"},
    {"excitation": "random", "window": "hann"},
    {"exciter": "hammer"},
    {"drive": "4:+Y"},
    {"responses": ["1:+Y", "3:+Y"]},
    {"added_mass": {"at": "sensors", "mass": 0.05}},
    {"added_mass": {"at": "1:+Y", "mass": 0.05}},
]


@pytest.mark.parametrize("plain", CHANGES, ids=str)
def test_a_change_is_read_as_it_is_written(plain: dict[str, Any]) -> None:
    assert Change.read(plain).plain == plain


@pytest.mark.parametrize("plain", CHANGES, ids=str)
def test_a_log_book_that_shows_a_change_and_one_that_does_not_come_to_the_same(plain: dict[str, Any]) -> None:
    first, change = rig(), Change.read(plain)
    changed = change.applied(first)
    assert changed != first
    assert change.agreed(changed, first) == changed
    assert change.agreed(first, first) == changed


def test_what_else_the_further_log_book_says_counts() -> None:
    first = rig()
    own = replace(first, analyser=replace(first.analyser, averages=40))
    agreed = Change(level_factor=3.0).agreed(own, first)
    assert (agreed.analyser.averages, agreed.analyser.excitation.level) == (40, 3.0)


@pytest.mark.parametrize(
    ("said", "shown"),
    [
        ({"level_factor": 3.0}, {"level_factor": 2.0}),
        ({"drive": "4:+Y"}, {"drive": "5:+Y"}),
        ({"n_lines": 321}, {"n_lines": 81}),
        ({"added_mass": {"at": "sensors", "mass": 0.05}}, {"added_mass": {"at": "sensors", "mass": 0.02}}),
        ({"added_mass": {"at": "4:+Y", "mass": 0.05}}, {"added_mass": {"at": "4:+Y", "mass": 0.02}}),
    ],
    ids=str,
)
def test_a_log_book_that_says_something_else_is_refused(said: dict[str, Any], shown: dict[str, Any]) -> None:
    first = rig()
    with pytest.raises(InvalidInputError) as refused:
        Change.read(said).agreed(Change.read(shown).applied(first), first)
    (name,) = said
    assert refused.value.context["field"] == f"changed.{name}"


@pytest.mark.parametrize(
    "plain",
    [{"colour": "red"}, {"level_factor": 0.0}, {"exciter": "loudspeaker"}, {"added_mass": {"mass": -1.0}}],
    ids=str,
)
def test_a_change_without_meaning_is_refused(plain: dict[str, Any]) -> None:
    with pytest.raises(InvalidInputError):
        Change.read(plain)


def test_a_hammer_leaves_nothing_of_the_shaker() -> None:
    struck = Change(exciter="hammer").applied(rig())
    assert struck.exciter.armature_mass == struck.force_transducer.mass_below == 0
    assert struck.analyser.excitation.kind == "impact"
    assert struck.accelerometers == rig().accelerometers


def test_declared_effects_go_where_the_shaker_goes() -> None:
    declared = EffectSpec("force_transducer_mass", Dof(1, "Y"), {"mass": 0.02})
    first = replace(rig(), effects=(declared,))
    moved = Change(drive=Dof(4, "Y")).applied(first)
    assert moved.effects == (replace(declared, at=Dof(4, "Y")),)
    assert Change(exciter="hammer").applied(first).effects == ()


DRIVE, OTHER = Dof(1, "Y"), Dof(4, "Y")


@pytest.mark.parametrize(
    ("effect", "after"),
    [
        (ExtraMass(at=DRIVE, mass=0.02), ExtraMass(at=DRIVE, mass=0.02)),
        (ForceTransducerMass(at=DRIVE, mass=0.02), ForceTransducerMass(at=OTHER, mass=0.02)),
        (ForceTransducerMass(mass=0.02), ForceTransducerMass(mass=0.02)),
        (GainError(at=DRIVE, factor=1.1), GainError(at=OTHER, factor=1.1)),
        (StingerBending(at=DRIVE), StingerBending(at=OTHER)),
    ],
)
def test_what_sits_at_the_drive_point_moves_with_it(effect: Effect, after: Effect) -> None:
    first = rig()
    moved = effects_in_other_test([effect], first, replace(first, drives=(OTHER,)))
    assert moved == [after]
    # Of effects that were named for the other test already nothing changes.
    assert effects_in_other_test(moved, first, replace(first, drives=(OTHER,))) == moved


@pytest.mark.parametrize(
    ("effect", "there"),
    [
        (ExtraMass(at=OTHER, mass=0.02), True),
        (ForceTransducerMass(mass=0.02), False),
        (StingerBending(at=DRIVE), False),
        (GainError(at=DRIVE, factor=1.1), False),  # a hammer has a gauge of its own
        (GainError(factor=1.1), True),  # of all responses
        (AccelerometerMass(mass=0.004), True),
    ],
)
def test_with_a_hammer_the_shakers_own_effects_are_gone(effect: Effect, there: bool) -> None:
    first = rig()
    assert effects_in_other_test([effect], first, Change(exciter="hammer").applied(first)) == [effect] * there


@pytest.mark.parametrize(
    ("effect", "there"),
    [
        (GainError(at=Channels((Dof(4, "Y"),)), factor=1.1), True),
        (GainError(at=Channels((Dof(9, "Y"),)), factor=1.1), False),
        (SwappedChannels(at=Channels((Dof(4, "Y"), Dof(9, "Y")))), False),
        (AccelerometerMass(at=Dof(9, "Y"), mass=0.01), False),
    ],
)
def test_a_channel_is_at_fault_where_it_is_used(effect: Effect, there: bool) -> None:
    first = rig()
    other = replace(first, responses=(DRIVE, OTHER))
    assert effects_in_other_test([effect], first, other) == [effect] * there
