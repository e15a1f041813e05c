"""Rules a rig should keep, held against rigid bodies on springs."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import UnknownDofError
from modallab.core.place import EffectSpec
from modallab.fe.settings import EIGENSOLUTION
from modallab.fe.structure import Support
from modallab.rig.checks import suspension_check
from modallab.rig.suspension import Suspension
from tests.rigs import dofs, rig, steel_beam

MASS = 7800.0 * 5e-4 * 1.5  # kg
ENDS = dofs(1, 21)


@pytest.mark.parametrize(("stiffness", "fulfilled"), [(20.0, True), (100.0, True), (300.0, False)])
def test_bands_at_the_ends_are_soft_enough_up_to_a_tenth(stiffness: float, fulfilled: bool) -> None:
    found = suspension_check(steel_beam(), rig(1, suspension=Suspension(ENDS, stiffness)))
    rocking = np.sqrt(6 * stiffness / MASS) / (2 * np.pi)  # 2 k (L/2)^2 over M L^2 / 12
    # bending gives way by k over the beam's own stiffness, under 2 % at 300 N/m
    assert found.highest_rigid_frequency == pytest.approx(rocking, rel=0.02)
    # 23.65 Hz of the free beam, lifted by k phi^2 / omega^2 with phi^2 = 4 / M at its ends
    lifted = 23.65 * (1 + stiffness * 4 / MASS / (2 * np.pi * 23.65) ** 2)
    assert found.first_elastic_frequency == pytest.approx(lifted, rel=1e-3)
    assert found.ratio == found.highest_rigid_frequency / found.first_elastic_frequency
    assert found.fulfilled is fulfilled


def test_a_structure_that_floats_or_is_held_keeps_the_rule() -> None:
    held = replace(steel_beam(), supports=(Support(1, ("Y", "RZ")),))
    for structure in (steel_beam(), held):
        found = suspension_check(structure, rig(5))
        assert (found.highest_rigid_frequency, found.ratio, found.fulfilled) == (0.0, 0.0, True)


def test_a_band_told_as_an_effect_counts_as_one_of_the_hardware() -> None:
    spec = [EffectSpec("suspension", dof, {"stiffness": 100.0}) for dof in ENDS]
    told = suspension_check(steel_beam(), rig(1, effects=tuple(spec)))
    declared = suspension_check(steel_beam(), rig(1, suspension=Suspension(ENDS, 100.0, 0.05)))
    assert told == declared


def test_a_large_structure_is_checked_as_a_small_one() -> None:
    fine = EIGENSOLUTION.dense_dofs // 2 + 10
    coarse = suspension_check(steel_beam(), rig(1, suspension=Suspension(ENDS, 100.0)))
    found = suspension_check(
        steel_beam(n_elements=fine), rig(1, suspension=Suspension(dofs(1, fine + 1), 100.0))
    )
    # elements of a 20th of the beam are near enough: (pi / 20)^4 / 720
    assert found.ratio == pytest.approx(coarse.ratio, rel=1e-5)


def test_a_band_where_there_is_no_node_is_refused() -> None:
    with pytest.raises(UnknownDofError):
        suspension_check(steel_beam(), rig(1, suspension=Suspension((Dof(99, "Y"),), 100.0)))
