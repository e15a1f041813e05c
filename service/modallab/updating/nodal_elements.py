"""Masses, springs to ground and joints that nodes have beside their members, as coefficients of an update."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.fe.structure import Structure
from modallab.updating.part import Part


def carried(structure: Structure, part: Part) -> dict[int, float]:
    """Return what nodes carry: masses, kg, springs to ground in a direction, N/m or N m/rad, or joints."""
    if part is Part.JOINT_STIFFNESS:
        return {joint.node: joint.stiffness for joint in structure.joints}
    if part is Part.POINT_MASS:
        pairs = [(point.node, point.mass) for point in structure.masses]
    else:
        springs = [spring for spring in structure.springs if spring.dof.direction == part.spring]
        pairs = [(spring.dof.node, spring.stiffness) for spring in springs]
    found: dict[int, float] = {}
    for node, value in pairs:
        found[node] = found.get(node, 0.0) + value
    return {node: value for node, value in found.items() if value > 0}


def refuse_absent(structure: Structure, part: Part, nodes: Iterable[int]) -> None:
    """Raise `InvalidInputError` unless every node carries what a coefficient is to multiply."""
    known = carried(structure, part)
    for node in nodes:
        if node not in known:
            raise InvalidInputError(
                f"node {node} carries no {part.words} that a coefficient could multiply",
                field="attached",
                value=node,
                allowed=", ".join(map(str, known)) or f"none: the structure has no {part.words}",
            )


def multiplied(structure: Structure, part: Part, nodes: Iterable[int], factor: float) -> Structure:
    """Return the structure with so many times what some nodes carry."""
    chosen = set(nodes)
    if part is Part.POINT_MASS:
        masses = (
            replace(one, mass=factor * one.mass) if one.node in chosen else one for one in structure.masses
        )
        return replace(structure, masses=tuple(masses))
    if part is Part.JOINT_STIFFNESS:
        joints = (
            replace(one, stiffness=factor * one.stiffness) if one.node in chosen else one
            for one in structure.joints
        )
        return replace(structure, joints=tuple(joints))
    springs = (
        replace(one, stiffness=factor * one.stiffness)
        if one.dof.node in chosen and one.dof.direction == part.spring
        else one
        for one in structure.springs
    )
    return replace(structure, springs=tuple(springs))


def node_matrices(structure: Structure, part: Part, nodes: Iterable[int]) -> tuple[FloatArray, IntArray]:
    """Return what nodes carry as matrices (n, 3, 3), and their place in the system, (n, 3), -1 where none.

    A mass moves with every translation of its node; a spring is alone in its direction.
    """
    known = carried(structure, part)
    wanted = tuple(nodes)
    rows = np.full((len(wanted), 3), -1)
    place = {node: i for i, node in enumerate(wanted)}
    for row, dof in enumerate(structure.dofs):
        own = dof.translational if part is Part.POINT_MASS else dof.direction == part.spring
        if own and dof.node in place:
            slots = rows[place[dof.node]]
            slots[np.flatnonzero(slots < 0)[0]] = row
    values = np.array([known[node] for node in wanted])
    return values[:, None, None] * np.eye(3), rows
