import numpy as np

from modallab.diagnosis.searching.starting_values import local_minima, near_minima
from modallab.effects.cable_mass import CableMass
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.polarity import Polarity
from modallab.rig.effect import Effect


def test_each_valley_along_the_amount_is_sent_the_deepest_first() -> None:
    sizes: list[Effect] = [ExciterArmature(mass=m) for m in (0.01, 0.02, 0.04, 0.08, 0.16)]
    assert local_minima(sizes, np.array([5.0, 2.0, 4.0, 1.0, 3.0])) == [3, 1]
    assert local_minima(sizes[::-1], np.array([3.0, 1.0, 4.0, 2.0, 5.0])) == [1, 3]


def test_a_valley_that_is_many_times_as_high_is_left() -> None:
    sizes: list[Effect] = [ExciterArmature(mass=m) for m in (0.01, 0.02, 0.04, 0.08)]
    assert local_minima(sizes, np.array([50.0, 400.0, 5.0, 10.0])) == [2]


def test_of_another_number_the_best_value_counts_at_every_amount() -> None:
    sizes: list[Effect] = [CableMass(mass=m, drag=d) for m in (0.01, 0.02, 0.04) for d in (20.0, 500.0)]
    assert local_minima(sizes, np.array([2.0, 9.0, 9.0, 4.0, 3.0, 9.0])) == [0, 4]


def test_what_has_no_number_has_one_size() -> None:
    assert local_minima([Polarity()], np.array([3.0])) == [0]


def test_beside_each_minimum_are_the_next_amounts() -> None:
    sizes: list[Effect] = [ExciterArmature(mass=m) for m in (0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64)]
    assert near_minima(sizes, np.array([2.0, 3.0, 2.5, 2.4, 2.3, 2.2, 2.6])) == [0, 1, 4, 5, 6]
