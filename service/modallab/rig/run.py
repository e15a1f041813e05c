"""One run of the analyser: loaded structure, exciters and channels."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.fe.system import DynamicSystem
from modallab.rig.channel import Channel
from modallab.rig.drive import Drive
from modallab.rig.equivalent_linearisation import LocalResponseSpectrum
from modallab.rig.local_force import LinearisedForce
from modallab.rig.setup import AcquisitionRun


@dataclass(frozen=True, eq=False)
class Run:
    """One run of the analyser: the structure as it is loaded then, its exciters, its channels."""

    acquisition_run: AcquisitionRun
    system: DynamicSystem
    drives: tuple[Drive, ...]
    forces: tuple[Channel, ...]
    responses: tuple[Channel, ...]
    local_forces: tuple[
        LinearisedForce, ...
    ] = ()  # nonlinear forces; the system includes their equivalent linearisation
    response_spectrum: LocalResponseSpectrum | None = None  # by them at the lines, where lines have it all
    _resonance_cache: dict[float, tuple[FloatArray, FloatArray]] = field(
        default_factory=dict, init=False, repr=False
    )

    @cached_property
    def motions(self) -> tuple[Dof, ...]:
        """DoFs whose motion is needed: drive points, nonlinear forces, pickups of the channels."""
        pickups = {dof: None for channel in self.responses for dof, _ in channel.pickups}
        return (
            *self.acquisition_run.drives,
            *(linearised_force.force.dof for linearised_force in self.local_forces),
            *pickups,
        )

    @property
    def n_forces(self) -> int:
        """Number of drive points and nonlinear forces."""
        return len(self.acquisition_run.drives) + len(self.local_forces)

    def channel_motions(self, accelerations: ComplexArray) -> ComplexArray:
        """Return the channels' motions from those of `motions` (n_freq, n_motions, n_sources)."""
        first = self.n_forces
        distinct = len(self.responses) == len(self.motions) - first
        if distinct and all(channel.pickups == ((channel.dof, 1.0),) for channel in self.responses):
            return accelerations[:, first:]
        place = {dof: i for i, dof in enumerate(self.motions[first:], start=first)}
        weights = np.zeros((len(self.responses), len(self.motions)))
        for i, channel in enumerate(self.responses):
            for dof, weight in channel.pickups:
                weights[i, place[dof]] += weight
        return np.asarray(weights @ accelerations)

    def resonances(self, frequency_max: float) -> tuple[FloatArray, FloatArray]:
        """Return frequency and half the half-power bandwidth, Hz, of structure and exciters together.

        Twice where coils are inductive: as they are at 0 Hz and at the top of the band. Between, what
        moves a resonance damps it as much. A current dies away as a resonance at 0 Hz does.
        """
        if frequency_max not in self._resonance_cache:
            self._resonance_cache[frequency_max] = self._resonances(frequency_max)
        return self._resonance_cache[frequency_max]

    @property
    def resonance_key(self) -> Hashable:
        """What the resonances depend on: equal for two runs of equal resonances."""
        if any(drive.electrical_decay_rates for drive in self.drives):
            return id(self)
        system = self.with_exciters
        return id(system.cache), tuple(attachment.key for attachment in system.attachments)

    def _resonances(self, frequency_max: float) -> tuple[FloatArray, FloatArray]:
        resonances = [self._with_exciters_at(0.0).resonances(frequency_max)]
        if any(drive.electrical_decay_rates for drive in self.drives):
            resonances.append(self._with_exciters_at(2 * np.pi * frequency_max).resonances(frequency_max))
            decays = np.array([rate for drive in self.drives for rate in drive.electrical_decay_rates]) / (
                2 * np.pi
            )
            resonances.append((np.zeros_like(decays), decays))
        frequencies, widths = zip(*resonances, strict=True)
        return np.concatenate(frequencies), np.concatenate(widths)

    @property
    def with_exciters(self) -> DynamicSystem:
        """The structure with the moving parts of the passive exciters attached."""
        return self._with_exciters_at(0.0)

    def _with_exciters_at(self, omega: float) -> DynamicSystem:
        system = self.system
        for drive in self.drives:
            system = drive.attached_to(system, omega)
        return system


def filtered(signals: ComplexArray, channels: Sequence[Channel], omega: FloatArray) -> ComplexArray:
    """Return signals (n_freq, n_ch, n_in) behind the filters of their channels."""
    if not any(channel.filters for channel in channels):
        return signals
    return np.asarray(signals * np.array([channel.transfer(omega) for channel in channels]).T[:, :, None])
