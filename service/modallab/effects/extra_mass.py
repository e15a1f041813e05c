"""Unmodelled point mass."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.fe.structure import PointMass, Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("extra_mass")
@dataclass(frozen=True)
class ExtraMass(Effect):
    """Point mass at one node in every run; it moves with all translations of the node.

    M' = M + m sum e e^T. To first order the relative decrease of omega is m phi^2 / 2, with phi the
    mass-normalised shape there: Rayleigh, The Theory of Sound (1894), chapter IV.
    """

    kind: ClassVar[str] = "extra_mass"
    summary: ClassVar[str] = "mass at one node that the model lacks"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    structural: ClassVar[bool] = True
    similar_kinds: ClassVar[tuple[str, ...]] = ("density_error",)
    same_in_all_runs: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    mass: float = parameter(0.05, unit="kg", lower=0.0, upper=10.0, doc="mass at the node")

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        if not isinstance(self.at, Dof):
            raise InvalidInputError("an extra mass sits at a DoF", field="at", value=str(self.at))
        return system.add_mass(self.at.node, self.mass)

    def added_to(self, structure: Structure) -> Structure:
        """Return the model with the mass on its node."""
        assert isinstance(self.at, Dof)
        return replace(structure, masses=(*structure.masses, PointMass(self.at.node, self.mass)))

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return one translation of every node."""
        firsts = {dof.node: dof for dof in reversed(system.dofs) if dof.translational}
        return tuple(firsts[node] for node in sorted(firsts))

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Frequencies fall, most for modes that move most at one point."""
        return 0.4 + 0.4 * evidence.falling
