"""Attached oscillator: a part with a resonance of its own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from modallab.core.dof import Dof
from modallab.core.parameters import ParameterSpec, parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.effects.settings import OSCILLATOR_SCAN
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("attached_oscillator")
@dataclass(frozen=True)
class AttachedOscillator(Effect):
    """Mass on a damped spring at one DoF: Z = -omega^2 m s / (s - omega^2 m).

    s = (2 pi f)^2 m (1 + i eta) + i omega c with the viscous damper c = 4 pi f m zeta, by default none.
    Below its own frequency it acts as a mass, above it as a spring. At its own frequency the DoF stands
    still, and one resonance becomes two. Den Hartog, Mechanical Vibrations (1956), chapter 3 (the dynamic
    vibration absorber).
    """

    kind: ClassVar[str] = "attached_oscillator"
    summary: ClassVar[str] = "attached part with a resonance of its own"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    structural: ClassVar[bool] = True
    same_in_all_runs: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    mass: float = parameter(0.05, unit="kg", lower=0.0, upper=100.0, doc="mass that moves on the spring")
    frequency: float = parameter(
        100.0, unit="Hz", lower=1e-3, upper=1e6, absent=None, doc="of the mass on its spring, DoF held"
    )
    loss_factor: float = parameter(0.05, unit="1", lower=1e-6, upper=2.0, absent=None, doc="of the spring")
    damping_ratio: float = parameter(
        0.0,
        unit="1",
        lower=0.0,
        upper=1.0,
        absent=None,
        doc="of a viscous damper beside the spring",
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        assert isinstance(self.at, Dof)
        if self.mass == 0:
            return system
        return system.add_oscillator(self.at, self.mass, self.frequency, self.loss_factor, self.damping_ratio)

    def variants(self, system: DynamicSystem) -> tuple[Self, ...]:
        """Return the oscillator with a viscous damper in place of the loss of its spring."""
        if self.damping_ratio > 0:
            return ()
        lossless = self.specs()["loss_factor"].lower
        return (replace(self, loss_factor=lossless, damping_ratio=self.loss_factor / 2),)

    def fitted_specs(self) -> list[tuple[str, ParameterSpec, float]]:
        """Return what a fit varies: the loss of the spring, or the viscous damper in its place."""
        fixed = "loss_factor" if self.damping_ratio > 0 else "damping_ratio"
        return [fitted for fitted in super().fitted_specs() if fitted[0] != fixed]

    def limiting_effects(self) -> tuple[Effect, ...]:
        """Return the mass of an oscillator far above the band, and the spring of a heavy one far below it."""
        stiffness = self.mass * (2 * np.pi * self.frequency) ** 2
        limits = (("extra_mass", "mass", self.mass), ("ground_spring", "stiffness", stiffness))
        return tuple(
            EFFECTS[kind](at=self.at).with_parameters({name: amount})
            for kind, name, amount in limits
            if amount <= EFFECTS[kind].specs()[name].upper
        )

    def check(self, structure: Structure, setup: RigSetup | None = None) -> None:
        """Raise unless it sits at a translation of the structure; see `Effect.check`."""
        super().check(structure, setup)
        if isinstance(self.at, Dof) and not self.at.translational:
            raise self._misplaced("a translation")

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return every translation."""
        return tuple(dof for dof in system.dofs if dof.translational)

    def scan_values(self, system: DynamicSystem, setup: RigSetup) -> Mapping[str, Sequence[float]]:
        """Return frequencies over the band, and masses of 1e-3 to 0.1 of the structure's."""
        top = setup.analyser.freq[-1]
        weight = float(system.mass.diagonal()[[dof.translational for dof in system.dofs]].sum())
        masses = [m for share in (1e-3, 1e-2, 1e-1) if (m := share * weight) <= self.specs()["mass"].upper]
        return {
            "frequency": [
                float(share * top)
                for share in np.arange(OSCILLATOR_SCAN.band_step, 1.0, OSCILLATOR_SCAN.band_step)
            ],
            "mass": masses,
        }

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return the evidence that some natural frequencies fall and others rise."""
        total_shift = np.abs(evidence.frequency_shift).sum()
        if not total_shift > 0:
            return 0.3
        return float(0.3 + 0.4 * (1 - np.abs(evidence.frequency_shift.sum()) / total_shift))
