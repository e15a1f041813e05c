"""Shear deformation and rotary inertia, neglected by Bernoulli-Euler beams."""

from dataclasses import dataclass, replace
from types import NoneType
from typing import ClassVar

from modallab.core.parameters import parameter, share_parameter
from modallab.core.place import Members
from modallab.correlation.evidence import Evidence
from modallab.fe.alteration import Alteration
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun


@EFFECTS.register("shear_and_rotary_inertia")
@dataclass(frozen=True)
class ShearAndRotaryInertia(Effect):
    """Timoshenko beam terms of members: phi = 12 E I / (kappa A G L^2), sections of inertia rho I.

    Both terms are proportional to `amount`; 1 corresponds to Poisson's ratio and shear coefficient of the
    model. Members whose element includes both terms do not change. The mass matrix is that of the sheared
    shape, or of Bernoulli and Euler's, as some programs have it; a diagnosis tries both. The frequencies of
    a slender bar decrease by the share (n pi r / L)^2 (1 + E / (kappa G)) / 2, r^2 = I / A. Timoshenko,
    Philosophical Magazine 41 (1921) 744-746; matrices: Friedman and Kosmatka, Computers and Structures 47
    (1993) 473-481.
    """

    kind: ClassVar[str] = "shear_and_rotary_inertia"
    summary: ClassVar[str] = "shear flexibility and rotary inertia of members"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    structural: ClassVar[bool] = True
    same_in_all_runs: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (NoneType, Members)
    amount: float = parameter(
        1.0,
        unit="1",
        lower=0.0,
        upper=30.0,
        doc="shear flexibility and rotary inertia over those of section and material",
        scan_values=(0.3, 1.0, 3.0, 10.0),
    )
    consistent_mass: float = share_parameter(
        doc="share of the shear in the shapes of the mass matrix; 0: those of Bernoulli and Euler",
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        if not isinstance(self.at, Members):
            return system.sheared(self.amount, self.consistent_mass)
        alteration = Alteration(shear=self.amount, consistent_mass=self.consistent_mass)
        for number in self.at.numbers:
            system = system.alter(number, alteration)
        return system

    def added_to(self, structure: Structure) -> Structure:
        """Return the model with Timoshenko's elements; with the effect in it where it has a share of them."""
        if self.amount != 1.0 or self.consistent_mass != 1.0:
            return super().added_to(structure)
        wrong = self.at.numbers if isinstance(self.at, Members) else [m.number for m in structure.members]
        members = tuple(
            replace(m, element="timoshenko") if m.number in wrong and m.element == "frame" else m
            for m in structure.members
        )
        return replace(structure, members=members)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Frequencies fall, the more the higher they are."""
        return 0.3 + 0.3 * evidence.falling
