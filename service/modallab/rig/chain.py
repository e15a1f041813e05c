"""A structure, a rig and effects put together: what each run's channels do at any frequency."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.fe.attachment import Attachment
from modallab.fe.receptance import attached, attached_variants
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import EFFECTS, Drive, Effect, NoiseLevels, Source, build
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.setup import RigSetup, Shot

# Of a line: 0 Hz is taken as a limit, where inertance stays finite. Near enough to be within 1e-6 of it,
# far enough for omega^2 to stand above the rounding in a free body's modal damping.
NEARLY_STILL = 1e-3
AT_ONCE = 4096  # frequencies at which the structure is asked at once: bounds the memory


@dataclass(frozen=True, eq=False)
class ChannelResponse:
    """What reaches the channels of every run for a unit force of the source."""

    transmission: ComplexArray  # (n_run, n_freq) F/P
    inertance: ComplexArray  # (n_run, n_freq, n_out) of the loaded structure, 1/kg


@dataclass(frozen=True, eq=False)
class Chain:
    """The loaded structure of every run, and what stands before and behind it."""

    setup: RigSetup
    shots: tuple[Shot, ...]
    systems: tuple[DynamicSystem, ...]  # one a run
    drive: Drive
    noise: NoiseLevels
    source: Source

    @property
    def overlap(self) -> float:
        """Share of a record that the next one has in common with it.

        Nothing where the declared excitation starts anew for every record.
        """
        analyser = self.setup.analyser
        return analyser.overlap if EXCITATIONS[analyser.excitation.kind].continuous > 0 else 0.0

    def respond(self, freq: FloatArray) -> ChannelResponse:
        """Return transmission and inertance of every run at `freq` (n_freq,) Hz."""
        top = float(freq.max())
        parts = [self._respond(freq[i : i + AT_ONCE], top) for i in range(0, len(freq), AT_ONCE)]
        accelerance = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
        return ChannelResponse(self.drive.transmission(accelerance[..., 0]), accelerance[..., 1:])

    def _respond(self, freq: FloatArray, top: float) -> ComplexArray:
        """Return the inertance of drive point and responses of every run, (n_run, n_freq, 1 + n_out)."""
        omega = 2 * np.pi * np.maximum(freq, NEARLY_STILL * self.setup.analyser.spacing)
        first = self.systems[0]
        own = first.selection((self.setup.drive,))
        lefts = [np.hstack([own, first.selection(shot.outputs)]) for shot in self.shots]
        if all(system.mass is first.mass for system in self.systems):
            alpha = attached_variants(self.systems, omega, lefts, own)
        else:  # an effect rebuilt the structure from run to run: each brings its own modes
            each = zip(self.systems, lefts, strict=True)
            alpha = np.array([attached(s.base_modes(top).at(omega), s, left, own) for s, left in each])
        return np.asarray(-(omega**2)[None, :, None] * alpha[..., 0])

    def poles(self) -> tuple[FloatArray, FloatArray]:
        """Return frequency and half the half-power bandwidth, Hz, of every run's resonances.

        Of structure and source moving together, as the spectra have them; (n_run, n_modes) each.
        """
        frequencies, widths = [], []
        top = self.setup.analyser.frequency_max
        for shot, system in zip(self.shots, self.systems, strict=True):
            column = system.selection((shot.drive,))
            whole = system.attach(Attachment(column, mass=np.array([[self.drive.mass]])))
            resonance, width = whole.resonances(top)
            frequencies.append(resonance)
            widths.append(width)
        return np.array(frequencies), np.array(widths)


def all_effects(setup: RigSetup, added: Sequence[Effect]) -> list[Effect]:
    """Return what the declared hardware implies, what the log book names, and `added`, in stage order."""
    implied = [effect for cls in EFFECTS.values() for effect in cls.from_setup(setup)]
    named = [build(spec) for spec in setup.effects]
    # What acts everywhere comes first: a member's own factor multiplies what holds for all members.
    return sorted([*implied, *named, *added], key=lambda effect: (effect.stage, effect.at is not None))


def chain(system: DynamicSystem, setup: RigSetup, added: Sequence[Effect] = ()) -> Chain:
    """Return the measuring chain of a system on a rig.

    Parameters
    ----------
    system
        The structure, bare.
    added
        Effects beside those of the declared hardware.

    Raises
    ------
    UnknownDofError
        If the structure lacks a DoF that the rig drives or listens at.
    """
    effects = all_effects(setup, added)
    for dof in (setup.drive, *setup.responses):
        system.index(dof)
    drive, noise = Drive(), NoiseLevels()
    source = Source(EXCITATIONS[setup.analyser.excitation.kind].continuous)
    for effect in effects:
        drive, noise, source = effect.on_drive(drive), effect.on_noise(noise), effect.on_source(source)
    systems = []
    for shot in setup.shots:
        loaded = system
        for effect in effects:
            loaded = effect.on_system(loaded, shot)
        systems.append(loaded)
    return Chain(setup, setup.shots, tuple(systems), drive, noise, source)
