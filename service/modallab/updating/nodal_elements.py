"""Point masses, ground springs and joints at nodes, as coefficients of an update."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.fe.structure import Structure
from modallab.updating.part import Part


def nodal_values(structure: Structure, part: Part) -> dict[int, float]:
    """Return values of a part by node: masses, kg, ground springs or joints, N/m or N m/rad."""
    if part is Part.JOINT_STIFFNESS:
        return {joint.node: joint.stiffness for joint in structure.joints}
    if part is Part.POINT_MASS:
        pairs = [(point.node, point.mass) for point in structure.masses]
    else:
        springs = [spring for spring in structure.springs if spring.dof.direction == part.spring]
        pairs = [(spring.dof.node, spring.stiffness) for spring in springs]
    total: dict[int, float] = {}
    for node, value in pairs:
        total[node] = total.get(node, 0.0) + value
    return {node: value for node, value in total.items() if value > 0}


def check_nodal_values(structure: Structure, part: Part, nodes: Iterable[int]) -> None:
    """Raise `InvalidInputError` unless every node has a mass, spring or joint to multiply."""
    values = nodal_values(structure, part)
    for node in nodes:
        if node not in values:
            raise InvalidInputError(
                f"node {node} carries no {part.label} that a coefficient could multiply",
                field="attached",
                value=node,
                allowed=list(values) or f"none: the structure has no {part.label}",
            )


def with_scaled_nodes(structure: Structure, part: Part, nodes: Iterable[int], factor: float) -> Structure:
    """Return the structure with the masses, springs or joints of some nodes multiplied by a factor."""
    numbers = set(nodes)
    if part is Part.POINT_MASS:
        masses = (
            replace(point, mass=factor * point.mass) if point.node in numbers else point
            for point in structure.masses
        )
        return replace(structure, masses=tuple(masses))
    if part is Part.JOINT_STIFFNESS:
        joints = (
            replace(joint, stiffness=factor * joint.stiffness) if joint.node in numbers else joint
            for joint in structure.joints
        )
        return replace(structure, joints=tuple(joints))
    springs = (
        replace(spring, stiffness=factor * spring.stiffness)
        if spring.dof.node in numbers and spring.dof.direction == part.spring
        else spring
        for spring in structure.springs
    )
    return replace(structure, springs=tuple(springs))


def node_matrices(structure: Structure, part: Part, nodes: Iterable[int]) -> tuple[FloatArray, IntArray]:
    """Return matrices of nodes (n, 3, 3), and their index in the system (n, 3), -1 where absent.

    A mass acts on every translation of its node; a spring acts in its direction only.
    """
    values_by_node = nodal_values(structure, part)
    numbers = tuple(nodes)
    rows = np.full((len(numbers), 3), -1)
    place = {node: i for i, node in enumerate(numbers)}
    for row, dof in enumerate(structure.dofs):
        is_matching = dof.translational if part is Part.POINT_MASS else dof.direction == part.spring
        if is_matching and dof.node in place:
            slots = rows[place[dof.node]]
            slots[np.flatnonzero(slots < 0)[0]] = row
    values = np.array([values_by_node[node] for node in numbers])
    return values[:, None, None] * np.eye(3), rows
