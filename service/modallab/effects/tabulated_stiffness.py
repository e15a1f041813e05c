"""Tabulated stiffness: a part whose dynamic stiffness is a curve over frequency."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from modallab.core.dof import Dof
from modallab.core.frequency_table import FrequencyTable
from modallab.core.parameters import parameter
from modallab.core.place import Place, TableRow
from modallab.correlation.evidence import Evidence
from modallab.fe.system import DynamicSystem
from modallab.fe.tabulated_attachment import TabulatedAttachment
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.setup import AcquisitionRun, RigSetup


@EFFECTS.register("tabulated_stiffness")
@dataclass(frozen=True)
class TabulatedStiffness(Effect):
    """Dynamic stiffness between a DoF and the ground that a table gives, Z' = Z + s z(f) e e^T.

    `table` holds rows of frequency, Hz, real and imaginary part of z, N/m (N m/rad for a rotation); between
    them z is a cubic spline, beyond them constant. With its curve an effect becomes part of the model that
    no formula describes. Its influence on receptances is a modification of rank one: Sherman and Morrison,
    Annals of Mathematical Statistics 21 (1950), 124-127.
    """

    kind: ClassVar[str] = "tabulated_stiffness"
    summary: ClassVar[str] = "part whose dynamic stiffness to the ground is a curve over frequency"
    stage: ClassVar[Stage] = Stage.STRUCTURE
    structural: ClassVar[bool] = True
    same_in_all_runs: ClassVar[bool] = True
    suspected: ClassVar[bool] = False
    tabulated: ClassVar[bool] = True
    allowed_places: ClassVar[tuple[type, ...]] = (Dof,)
    scale: float = parameter(1.0, unit="1", lower=-100.0, upper=100.0, doc="factor of the tabulated curve")
    table: tuple[TableRow, ...] = ((0.0, 1e4, 1e3), (200.0, 2e4, 4e3))

    def __post_init__(self) -> None:
        super().__post_init__()
        FrequencyTable(self.table)

    def on_system(self, system: DynamicSystem, acquisition_run: AcquisitionRun) -> DynamicSystem:
        assert isinstance(self.at, Dof)
        if self.scale == 0:
            return system
        table = FrequencyTable(self.table)
        return system.attach(TabulatedAttachment(system.selection((self.at,)), table=table, scale=self.scale))

    @classmethod
    def places(cls, system: DynamicSystem, setup: RigSetup) -> Sequence[Place]:
        """Return every translation of the structure."""
        return tuple(dof for dof in system.dofs if dof.translational)

    @classmethod
    def signature(cls, evidence: Evidence) -> float:
        """Return a low suspicion: a curve can imitate anything at its place."""
        return 0.1
