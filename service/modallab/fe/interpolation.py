"""Motion of a point beside a node by the shape functions of its member."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.fe.member_table import MemberTable


def point_motion(
    table: MemberTable, node: int, distance: float, direction: str
) -> tuple[tuple[int, float], ...]:
    """Return the motion of a point beside a node as rows of the system and their weights.

    Linear interpolation along the member and the Bernoulli-Euler cubic across it, exact for a member
    loaded at its ends only. Beyond a free end the point is on a rigid extension.

    Parameters
    ----------
    distance
        m along the members from the node: forward into the first one that starts there, backward
        into the first that ends there, and on into the next where it is longer than that.
    direction
        "X" or "Y".
    """
    e, s = _member_at(table, node, distance)
    start, end = table.points[e]
    length = float(np.hypot(*(end - start)))
    cosine, sine = (end - start) / length
    along, across = (cosine, -sine) if direction == "X" else (sine, cosine)
    axial, sway, slope = _shapes(s, length)
    x = along * axial * cosine - across * sway * sine
    y = along * axial * sine + across * sway * cosine
    weights = np.stack([x, y, across * slope], axis=1).ravel()
    return tuple((int(r), float(w)) for r, w in zip(table.rows[e], weights, strict=True) if r >= 0)


def _member_at(table: MemberTable, node: int, distance: float) -> tuple[int, float]:
    """Return the index of the member of a point beside a node, and the distance from its first end, m."""
    lengths = np.hypot(*(table.points[:, 1] - table.points[:, 0]).T)
    forward, remaining_distance = distance >= 0, abs(distance)
    last, e = None, _next_member(table, node, forward, None)
    if e is None:  # only other ends of members join here: a rigid extension
        last = _next_member(table, node, not forward, None)
    while e is not None and remaining_distance > lengths[e]:
        remaining_distance -= lengths[e]
        node = table.ends[e][0] if table.ends[e][1] == node else table.ends[e][1]
        last, e = e, _next_member(table, node, forward, e)
    if e is not None:
        return e, remaining_distance if table.ends[e][0] == node else lengths[e] - remaining_distance
    assert last is not None  # a node that no member joins is no part of a structure
    return last, -remaining_distance if table.ends[last][0] == node else lengths[last] + remaining_distance


def _next_member(table: MemberTable, node: int, forward: bool, previous: int | None) -> int | None:
    """Return the index of the next member from a node, None if there is none.

    At a node where all members start, or all end, the second one is the way back.
    """
    joined = [e for e, ends in enumerate(table.ends) if table.bars[e] and node in ends and e != previous]
    outgoing = [e for e in joined if table.ends[e][0 if forward else 1] == node]
    if outgoing or previous is not None:
        return (outgoing or joined or [None])[0]  # type: ignore[list-item]
    return joined[1] if len(joined) > 1 else None


def _shapes(s: float, length: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the axial, transverse and rotational shape functions of both ends at `s`, (2,) each."""
    clipped = min(max(s, 0.0), length)
    t, extension = clipped / length, s - clipped
    axial = np.array([1 - t, t])
    sway = np.array([1 - 3 * t**2 + 2 * t**3, 3 * t**2 - 2 * t**3])
    slope = np.array([t - 2 * t**2 + t**3, t**3 - t**2]) * length
    slope += extension * np.array([float(s < 0), float(s > length)])
    return axial, sway, slope
