"""Translations of a point of a structure, and masses there."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import UnknownDofError
from modallab.fe.attachment import Attachment
from modallab.fe.interpolation import point_motion
from modallab.fe.system import DynamicSystem

Point = tuple[int, float]
"""A node, and the distance in m from it along its members; see `point_motion`."""


def point_translations(system: DynamicSystem, point: Point) -> FloatArray:
    """Return the translations (n, r) of a point: r columns of weights of the system's DoFs.

    Raises
    ------
    UnknownDofError
        If a point beside a node has no bar there.
    """
    node, distance = point
    if not distance:
        return system.selection(tuple(d for d in system.dofs if d.node == node and d.translational))
    table = system.members
    if table is None or not table.has_bar(node):
        raise UnknownDofError(f"node {node} has no bar that a point could be on", field="node", value=node)
    columns = np.zeros((len(system.dofs), 2))
    for i, direction in enumerate("XY"):
        for row, weight in point_motion(table, node, distance, direction):
            columns[row, i] = weight
    return columns[:, columns.any(axis=0)]


def add_point_masses(system: DynamicSystem, points: Sequence[Point], mass: float) -> DynamicSystem:
    """Return the system with the same mass, kg, at each of some points."""
    system = system.add_masses([node for node, distance in points if not distance], mass)
    for point in points:
        if point[1]:
            columns = point_translations(system, point)
            system = system.attach(Attachment(columns, mass=mass * np.eye(columns.shape[1])))
    return system
