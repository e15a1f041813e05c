"""Damping model: viscous instead of structural damping, or the reverse."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("damping_law")
@dataclass(frozen=True)
class DampingLaw(Effect):
    """Share s of the damping that follows the other law: viscous in place of hysteretic, or the reverse.

    i D becomes i (1 - s) D + i omega s C with C = D / omega_f: both laws dissipate equally at the reference
    frequency f; below it viscous damping dissipates less, above it more, so that the loss factor of a mode
    becomes eta_r (1 - s + s omega_r / omega_f). In a viscous model C becomes (1 - s) C and D = s omega_f C.
    Bishop and Johnson, The Mechanics of Vibration (1960), chapter 9. Only the damping of the structure's
    law changes; loss factors of members under a viscous law, and attached dampers, do not.
    """

    kind: ClassVar[str] = "damping_law"
    summary: ClassVar[str] = "viscous damping that the model has as structural, or the reverse"
    title: ClassVar[str] = "damping of another law than modelled"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    structural: ClassVar[bool] = True
    same_in_all_runs: ClassVar[bool] = True
    of_stated_damping: ClassVar[bool] = True
    share: float = parameter(
        0.5, unit="1", lower=0.0, upper=1.0, doc="of the loss that follows the other law"
    )
    frequency: float = parameter(
        150.0,
        unit="Hz",
        lower=0.01,
        upper=1e6,
        absent=None,
        doc="at which both laws dissipate equally",
        scan_values=(30.0, 150.0, 750.0),
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        return system.converted(self.share, 2 * np.pi * self.frequency) if self.share else system

    def limiting_effects(self) -> tuple[Effect, ...]:
        """Return the loss factor error that it tends to where the reference frequency leaves the band."""
        return (EFFECTS["loss_factor_error"]().with_parameters({"factor": 1 - self.share}),)

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return everywhere, of a structure that has losses."""
        lossy = system.damping is not None or system.viscous is not None or system.modal
        return (None,) if system.members and lossy else ()

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Peaks are too high at one end of the band and too low at the other."""
        if len(evidence.mode_frequency) < 2:
            return 0.2
        lines = np.abs(evidence.freq[:, None] - evidence.mode_frequency).argmin(axis=0)
        residual = (evidence.frf.real * evidence.weight)[lines].sum(axis=1)
        order = np.argsort(evidence.mode_frequency)
        trend = np.linspace(-1.0, 1.0, len(order))
        size = float(np.sqrt((residual**2).sum() * (trend**2).sum()))
        return 0.2 + 0.5 * evidence.at_peaks * abs(float(residual[order] @ trend)) / max(size, 1e-300)
