"""The model of a test with its nuisance parameters at a position."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.optimisation.nuisances import Nuisances, split_by_scope
from modallab.fe.assembly import assemble
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import Effect, build
from modallab.rig.setup import AcquisitionRun


@dataclass(frozen=True, eq=False)
class DeviatingModel:
    """The model, its own effects, and the deviations of the nuisance parameters."""

    system: DynamicSystem
    """The model without transducers and without deviations."""
    deviating_system: DynamicSystem
    """The same with the deviations of the whole structure, and with effects folded into its matrices."""
    model_effects: tuple[Effect, ...]
    """Effects that the model declares."""
    nuisances: Nuisances = field(default_factory=Nuisances)
    """Nuisance parameters."""
    position: FloatArray = field(default_factory=lambda: np.zeros(0))
    """(n,) of the nuisance parameters, standard deviations."""
    run_deviations: tuple[Effect, ...] = ()
    """Deviations of transducers and channels, which act in each run."""

    @classmethod
    def of(cls, structure: Structure) -> "DeviatingModel":
        """Return the state of a model without nuisance parameters."""
        system = assemble(structure)
        return cls(system, system, tuple(build(spec) for spec in structure.effects))

    def at_position(self, position: FloatArray, run: AcquisitionRun) -> "DeviatingModel":
        """Return the state with the nuisance parameters at a position (n,)."""
        # Deviations of the whole structure are equal in every run: applied once.
        global_effects, deviations = split_by_scope(self.nuisances.effects(position))
        system = self.system
        for effect in global_effects:
            system = effect.on_system(system, run)
        return replace(self, deviating_system=system, position=position, run_deviations=tuple(deviations))

    def folded(self, effects: Sequence[Effect], run: AcquisitionRun) -> "DeviatingModel":
        """Return the state with effects in the matrices of the structure."""
        system = self.deviating_system
        for effect in effects:
            system = effect.on_system(system, run)
        return replace(self, deviating_system=system.with_loss_of_altered_modes().folded())
