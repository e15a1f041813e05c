"""Drift of stiffness between the runs of a test."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from modallab.core.parameters import parameter
from modallab.core.place import Place
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("drift")
@dataclass(frozen=True)
class Drift(Effect):
    """Linear change of the stiffness of all members from the first run of a test to the last.

    K' = K (1 + change tau), tau from 0 to 1 in even steps: natural frequencies change by sqrt(1 + change
    tau), shapes do not, so that every FRF belongs to another structure. A steel beam that warms by 10 K
    loses 0.3 % of its modulus. Non-stationarity of a test, 1992 thesis, chapter 5. Stiffness-proportional
    damping changes with the stiffness; a test of one run has no drift.
    """

    kind: ClassVar[str] = "drift"
    summary: ClassVar[str] = "stiffness changes between the runs of a test, as with temperature"
    title: ClassVar[str] = "drift of the stiffness between runs"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    structural: ClassVar[bool] = True
    change: float = parameter(
        -0.01, unit="1", lower=-0.3, upper=0.3, doc="of stiffness from the first run to the last, relative"
    )

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        return system.scaled(stiffness=1 + self.change * acquisition_run.elapsed)

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return everywhere, of a test that takes several runs."""
        return (None,) if system.members and len(setup.acquisition_runs) > 1 else ()

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Responses that are measured late disagree more than those measured early."""
        channel = evidence.by_channel
        third = max(len(channel) // 3, 1)
        if len(channel) < 2 or channel.sum() == 0:
            return 0.2
        early, late = float(channel[:third].mean()), float(channel[-third:].mean())
        return 0.2 + 0.5 * max(0.0, late - early) / (late + early + 1e-300)
