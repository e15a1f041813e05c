"""Flexibility of a joint, or a crack, in bending."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import parameter
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

    The deflection is continuous. One side of the spring is the first member at the node, the other side all
    other members. To first order d(omega^2) / omega^2 = -flexibility M(x)^2 / 2U, with M the bending moment
    and U the strain energy of the mode (Rayleigh). A crack as such a spring: Chondros and Dimarogonas,
    Journal of Sound and Vibration 69 (1980) 531-538. Its mass matrix is that of the kinked shape, or the
    unchanged one, as in finite elements with a crack: Qian, Gu and Jiang, Journal of Sound and Vibration 138
    (1990) 233-243. The difference is as small as the element is short; a diagnosis tries both.
    """

    kind: ClassVar[str] = "joint_flexibility"
    summary: ClassVar[str] = "crack or loose joint, flexible in bending"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    structural: ClassVar[bool] = True
    same_in_all_runs: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    flexibility: float = parameter(
        1e-4, unit="rad/(N m)", lower=0.0, upper=1e6, doc="rotation of one side against the other per moment"
    )
    consistent_mass: float = parameter(
        1.0,
        unit="1",
        lower=0.0,
        upper=1.0,
        absent=None,
        doc="share of the kink that the member's mass matrix has; 0: it is unchanged",
        alternative=0.0,
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        assert isinstance(self.at, Dof)
        return system.add_joint(self.at.node, self.flexibility, self.consistent_mass)

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless it sits where members can turn against one another; see `Effect.check`."""
        super().check(structure, setup)
        assert isinstance(self.at, Dof)
        meeting = [m.number for m in structure.members if self.at.node in m.nodes]
        if self.at.direction != "RZ" or len(meeting) < 2:
            raise self._misplaced("RZ of a node where two members meet")

    def added_to(self, structure: Structure) -> Structure:
        """Return the model with the joint in it, in series with one that is there."""
        assert isinstance(self.at, Dof)
        node, flexibility = self.at.node, self.flexibility
        if not flexibility:
            return structure
        if self.consistent_mass < 1:
            return super().added_to(structure)
        other_joints = tuple(joint for joint in structure.joints if joint.node != node)
        flexibility += sum(1 / joint.stiffness for joint in structure.joints if joint.node == node)
        return replace(structure, joints=(*other_joints, JointSpring(node, 1 / flexibility)))

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return the rotation of every node where two members or more meet."""
        joints = system.members.joints if system.members else ()
        return tuple(dof for dof in system.dofs if dof.direction == "RZ" and dof.node in joints)

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
