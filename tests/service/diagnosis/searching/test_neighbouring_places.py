"""Places next to an effect's own."""

import pytest

from modallab.core.dof import Dof
from modallab.core.place import Channels, Members, Place
from modallab.diagnosis.searching.neighbouring_places import neighbouring_effects, similar_effects
from modallab.effects.density_error import DensityError
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.gain_error import GainError
from modallab.effects.stiffness_error import StiffnessError
from modallab.rig.effect import Effect
from tests.diagnosing import rig
from tests.rigs import beam_system, dofs


@pytest.mark.parametrize(
    ("effect", "places"),
    [
        (ExtraMass(Dof(4, "Y"), 0.02), [Dof(3, "Y"), Dof(5, "Y")]),
        (ExtraMass(Dof(1, "Y"), 0.02), [Dof(2, "Y")]),
        (StiffnessError(Members((7,)), 0.9), [Members((6,)), Members((8,))]),
        (StiffnessError(Members((7, 8)), 0.9), []),
        (StiffnessError(None, 0.9), []),
        (GainError(Channels(dofs(4)), 1.1), []),
    ],
    ids=str,
)
def test_they_share_a_member_or_a_node(effect: Effect, places: list[Place]) -> None:
    found = neighbouring_effects(effect, beam_system())
    assert [neighbour.at for neighbour in found] == places
    assert all(neighbour.parameters == effect.parameters for neighbour in found)


@pytest.mark.parametrize(
    ("effect", "kind", "places"),
    [
        (ExtraMass(Dof(4, "Y"), 0.02), "density_error", [Members((3,)), Members((4,))]),
        (DensityError(Members((7,)), 0.9), "extra_mass", [Dof(7, "Y"), Dof(8, "Y")]),
        (DensityError(None, 0.9), "extra_mass", []),
        (GainError(Channels(dofs(4)), 1.1), "extra_mass", []),
    ],
    ids=str,
)
def test_similar_kinds_touch_a_place(effect: Effect, kind: str, places: list[Place]) -> None:
    found = similar_effects(effect, beam_system(), rig())
    assert [similar.at for similar in found if similar.kind == kind] == places
    assert all(similar.kind == kind for similar in found)
