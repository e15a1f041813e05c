"""Flexibility of a joint, or a crack, in bending."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.parameters import parameter, share_parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import JOINT_SCAN
from modallab.fe.structure import JointSpring, Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("joint_flexibility")
@dataclass(frozen=True)
class JointFlexibility(Effect):
    """Rotational spring at a node: the slope changes there by `flexibility` times the bending moment.

    The deflection is continuous. One side of the spring is one member at the node, the other side all other
    members. To first order d(omega^2) / omega^2 = -flexibility M(x)^2 / 2U, with M the bending moment
    and U the strain energy of the mode (Rayleigh). A crack as such a spring: Chondros and Dimarogonas,
    Journal of Sound and Vibration 69 (1980) 531-538. Its mass matrix is that of the kinked shape, or the
    unchanged one, as in finite elements with a crack: Qian, Gu and Jiang, Journal of Sound and Vibration 138
    (1990) 233-243. The difference is as small as the element is short; a diagnosis tries both, and every
    member at the node.
    """

    kind: ClassVar[str] = "joint_flexibility"
    summary: ClassVar[str] = "crack or loose joint, flexible in bending"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    structural: ClassVar[bool] = True
    similar_kinds: ClassVar[tuple[str, ...]] = ("stiffness_error",)
    same_in_all_runs: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    flexibility: float = parameter(
        1e-4, unit="rad/(N m)", lower=0.0, upper=1e6, doc="rotation of one side against the other per moment"
    )
    consistent_mass: float = share_parameter(
        doc="share of the kink that the member's mass matrix has; 0: it is unchanged",
    )
    member: float = parameter(
        0.0,
        unit="1",
        lower=0.0,
        upper=1e9,
        absent=None,
        doc="number of the member whose end is flexible; 0: the first one that ends at the node",
        chosen=True,
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        assert isinstance(self.at, Dof)
        return system.add_joint(
            self.at.node, self.flexibility, self.consistent_mass, int(self.member) or None
        )

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless it sits where members can turn against one another; see `Effect.check`."""
        super().check(structure, setup)
        assert isinstance(self.at, Dof)
        meeting = [m.number for m in structure.members if self.at.node in m.nodes]
        if self.at.direction != "RZ" or len(meeting) < 2:
            raise self._misplaced("RZ of a node where two members meet")
        if self.member and self.member not in meeting:
            raise InvalidInputError(
                f"member {self.member:g} does not end at node {self.at.node}",
                field="member",
                value=self.member,
                allowed=[0, *meeting],
            )

    def added_to(self, structure: Structure) -> Structure:
        """Return the model with the joint in it, in series with one that is there."""
        assert isinstance(self.at, Dof)
        node, flexibility = self.at.node, self.flexibility
        if not flexibility:
            return structure
        if self.consistent_mass < 1 or self.member:
            return super().added_to(structure)
        other_joints = tuple(joint for joint in structure.joints if joint.node != node)
        flexibility += sum(1 / joint.stiffness for joint in structure.joints if joint.node == node)
        return replace(structure, joints=(*other_joints, JointSpring(node, 1 / flexibility)))

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return the rotation of every node where two members or more meet."""
        joints = system.members.joints if system.members else ()
        return tuple(dof for dof in system.dofs if dof.direction == "RZ" and dof.node in joints)

    def variants(self, system: DynamicSystem) -> tuple[Self, ...]:
        """Return the joint at the end of every member at the node, with both mass matrices.

        Of two members alone a consistent mass matrix is the same at either side.
        """
        assert isinstance(self.at, Dof)
        assert system.members is not None
        _, *others = system.members.bars_at(self.at.node)
        choices = [(0, 1.0), (0, 0.0), *((number, 0.0) for number in others)]
        if len(others) > 1:
            choices += [(number, 1.0) for number in others]
        found = (replace(self, member=float(number), consistent_mass=mass) for number, mass in choices)
        return tuple(effect for effect in found if effect != self)

    def scan_values(self, system: DynamicSystem, setup: RigSetup) -> Mapping[str, Sequence[float]]:
        """Return flexibilities around that of the member's end."""
        assert isinstance(self.at, Dof)
        assert system.members is not None
        end_flexibility = 1 / system.members.end_stiffness(self.at.node)
        upper = self.specs()["flexibility"].upper
        return {
            "flexibility": [
                float(end_flexibility * share)
                for share in np.logspace(*JOINT_SCAN.decades, JOINT_SCAN.n_values)
                if end_flexibility * share <= upper
            ]
        }

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Frequencies fall, but not of modes without a bending moment at the node."""
        return 0.3 + 0.4 * evidence.falling
