"""Joint rotations as rows of the system after those of the degrees of freedom."""

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.fe.alteration import ROTATION_ROWS
from modallab.fe.member_table import released_end
from modallab.fe.structure import Member, Structure


class JointRotations:
    """Relative rotations, rad, of member ends to their nodes at the joints of a structure.

    A member's matrices have an additional row for the joint rotation of each of its released ends.

    Parameters
    ----------
    width
        w, rows of a member without joint rotations.
    """

    def __init__(self, structure: Structure, width: int) -> None:
        members = structure.all_members
        place = {member.number: i for i, member in enumerate(members)}
        ends = [member.nodes for member in members]
        bars = np.array([isinstance(member, Member) for member in members])
        joints_of_member: dict[int, int] = {}
        joint_rows = []
        for joint in structure.joints:
            number, end = released_end(tuple(place), ends, bars, joint.node)
            member = place[number]
            column = width + joints_of_member.get(member, 0)
            joints_of_member[member] = joints_of_member.get(member, 0) + 1
            joint_rows.append((member, ROTATION_ROWS[end], column))
        # (n_joints,) each: member, row of the rotation of its end, row of the joint rotation
        self.members, self._end_rows, self._columns = np.array(joint_rows, int).reshape(-1, 3).T
        self.member_width, self.width = width, width + max(joints_of_member.values(), default=0)

    def widened(self, parts: FloatArray, places: IntArray) -> FloatArray:
        """Return matrices (m, w, w) of members, by their index, as (m, w', w') with joint rotations."""
        more = self.width - parts.shape[-1]
        out = np.pad(parts, ((0, 0), (0, more), (0, more)))
        at = {int(place): i for i, place in enumerate(places)}
        for member, row, column in zip(self.members, self._end_rows, self._columns, strict=True):
            if (i := at.get(int(member))) is not None:
                out[i, :, column] = out[i, :, row]
                out[i, column] = out[i, row]
        return out

    def rows(self, rows: IntArray, first: int) -> IntArray:
        """Return the system rows (n_members, w') of members; joint rotations begin at row `first`."""
        out = np.pad(rows, ((0, 0), (0, self.width - rows.shape[1])), constant_values=-1)
        out[self.members, self._columns] = first + np.arange(len(self.members))
        return out

    def springs(self, structure: Structure) -> FloatArray:
        """Return the stiffness of joints at their joint rotations, (n_members, w', w'), N m/rad."""
        out = np.zeros((len(structure.all_members), self.width, self.width))
        out[self.members, self._columns, self._columns] = [joint.stiffness for joint in structure.joints]
        return out
