"""Places next to an effect's place on the structure."""

from dataclasses import replace

from modallab.core.dof import Dof
from modallab.core.place import Members, Place
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.setup import RigSetup


def neighbouring_effects(effect: Effect, system: DynamicSystem) -> list[Effect]:
    """Return a copy of an effect of the structure at each adjoining place, parameters unchanged.

    Places that adjoin a DoF are the same direction at the other ends of its node's members; those that
    adjoin a member are the members that share a node with it. An effect of the rig, of the whole structure
    or of several members has none.
    """
    if not effect.structural or system.members is None:
        return []
    ends = dict(zip(system.members.numbers, system.members.ends, strict=True))
    places: list[Place] = []
    if isinstance(effect.at, Dof):
        node = effect.at.node
        nodes = {end for pair in ends.values() if node in pair for end in pair} - {node}
        dofs = {dof.point for dof in system.dofs}
        neighbours = [replace(effect.at, node=number) for number in sorted(nodes)]
        places += [dof for dof in neighbours if dof.point in dofs]
    elif isinstance(effect.at, Members) and len(effect.at.numbers) == 1:
        (member,) = effect.at.numbers
        joined = set(ends[member])
        places += [
            Members((number,)) for number, pair in ends.items() if number != member and joined & set(pair)
        ]
    return [replace(effect, at=place) for place in places]


def similar_effects(effect: Effect, system: DynamicSystem, setup: RigSetup) -> list[Effect]:
    """Return effects of similar kinds at the places that touch an effect's place, with typical parameters.

    A node touches the members that end there.
    """
    if system.members is None:
        return []
    ends = dict(zip(system.members.numbers, system.members.ends, strict=True))

    def nodes(place: Place) -> set[int]:
        if isinstance(place, Dof):
            return {place.node}
        return (
            {end for number in place.numbers for end in ends[number]} if isinstance(place, Members) else set()
        )

    similar = [EFFECTS[kind] for kind in effect.similar_kinds]
    return [cls(at=at) for cls in similar for at in cls.places(system, setup) if nodes(at) & nodes(effect.at)]
