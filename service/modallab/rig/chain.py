"""A structure, a rig and effects put together: what each run's channels do at any frequency."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.fe.receptance import attached, attached_variants
from modallab.fe.system import DynamicSystem
from modallab.rig.channel import Channel
from modallab.rig.drive import Drive, transmission
from modallab.rig.effect import EFFECTS, Effect, build
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.setup import RigSetup, Shot
from modallab.rig.source import NoiseLevels, Source

# Of a line: 0 Hz is taken as a limit, where inertance stays finite. Near enough to be within 1e-6 of it,
# far enough for omega^2 to stand above the rounding in a free body's modal damping.
NEARLY_STILL = 1e-3
AT_ONCE = 4096  # frequencies at which the structure is asked at once: bounds the memory


@dataclass(frozen=True, eq=False)
class ChannelResponse:
    """What the channels of every run show for a unit force of each source."""

    force: ComplexArray  # (n_run, n_freq, n_in, n_in)
    response: ComplexArray  # (n_run, n_freq, n_out, n_in) m/s^2 per N of the source

    @property
    def channels(self) -> ComplexArray:
        """(n_run, n_freq, n_ch, n_in): forces first."""
        return np.concatenate([self.force, self.response], axis=2)

    @property
    def inertance(self) -> ComplexArray:
        """(n_run, n_freq, n_out, n_in) 1/kg: responses per forces, as the channels show both."""
        if self.force.shape[-1] == 1:
            return np.asarray(self.response / self.force)
        solved = np.linalg.solve(self.force.swapaxes(2, 3), self.response.swapaxes(2, 3))
        return np.asarray(solved.swapaxes(2, 3))


@dataclass(frozen=True, eq=False)
class Run:
    """One run of the analyser: the structure as it is loaded then, its exciters, its channels."""

    shot: Shot
    system: DynamicSystem
    drives: tuple[Drive, ...]
    forces: tuple[Channel, ...]
    responses: tuple[Channel, ...]

    @cached_property
    def motions(self) -> tuple[Dof, ...]:
        """What has to be known of the structure: drive points first, then what reaches the channels."""
        heard = {dof: None for channel in self.responses for dof, _ in channel.pickups}
        return (*self.shot.drives, *heard)

    def mixed(self, heard: ComplexArray) -> ComplexArray:
        """Return what reaches each response channel of `motions` (n_freq, n_motions, n_in)."""
        first = len(self.shot.drives)
        if all(channel.pickups == ((channel.dof, 1.0),) for channel in self.responses):
            return heard[:, first:]
        place = {dof: i for i, dof in enumerate(self.motions[first:], start=first)}
        weights = np.zeros((len(self.responses), len(self.motions)))
        for i, channel in enumerate(self.responses):
            for dof, weight in channel.pickups:
                weights[i, place[dof]] += weight
        return np.asarray(weights @ heard)


def _transmissions(runs: Sequence[Run], omega: FloatArray, alpha: ComplexArray) -> ComplexArray:
    """Return the force on the structure per force of each source, (n_run, n_freq, n_in, n_in)."""
    if all(run.drives == runs[0].drives for run in runs):
        return transmission(runs[0].drives, omega, alpha)
    each = zip(runs, alpha, strict=True)
    return np.array([transmission(run.drives, omega, own[None])[0] for run, own in each])


def _filtered(signals: ComplexArray, channels: Sequence[Channel], omega: FloatArray) -> ComplexArray:
    """Return signals (n_freq, n_ch, n_in) behind the filters of their channels."""
    if not any(channel.filters for channel in channels):
        return signals
    return np.asarray(signals * np.array([channel.transfer(omega) for channel in channels]).T[:, :, None])


@dataclass(frozen=True, eq=False)
class Chain:
    """The loaded structure of every run, and what stands before and behind it."""

    setup: RigSetup
    runs: tuple[Run, ...]
    noise: NoiseLevels
    source: Source
    effects: tuple[Effect, ...]  # all of them, in stage order

    @property
    def n_in(self) -> int:
        """How many sources drive at the same time."""
        return len(self.runs[0].drives)

    @property
    def overlap(self) -> float:
        """Share of a record that the next one has in common with it.

        Nothing where the declared excitation starts anew for every record.
        """
        analyser = self.setup.analyser
        return analyser.overlap if EXCITATIONS[analyser.excitation.kind].continuous > 0 else 0.0

    def respond(self, freq: FloatArray) -> ChannelResponse:
        """Return what the channels of every run show at `freq` (n_freq,) Hz."""
        top = float(freq.max())
        parts = [self._respond(freq[i : i + AT_ONCE], top) for i in range(0, len(freq), AT_ONCE)]
        if len(parts) == 1:
            return parts[0]
        return ChannelResponse(
            np.concatenate([part.force for part in parts], axis=1),
            np.concatenate([part.response for part in parts], axis=1),
        )

    def _respond(self, freq: FloatArray, top: float) -> ChannelResponse:
        omega = 2 * np.pi * np.maximum(freq, NEARLY_STILL * self.setup.analyser.spacing)
        force: list[ComplexArray] = [np.zeros(0, complex)] * len(self.runs)
        response = list(force)
        for group in self._groups():
            runs = [self.runs[i] for i in group]
            alpha = self._receptance(runs, omega, top)
            through = _transmissions(runs, omega, alpha[:, :, : self.n_in])
            heard = -(omega**2)[None, :, None, None] * (alpha @ through)
            for place, i in enumerate(group):
                force[i] = _filtered(through[place], self.runs[i].forces, omega)
                mixed = self.runs[i].mixed(heard[place])
                response[i] = _filtered(mixed, self.runs[i].responses, omega)
        return ChannelResponse(np.array(force), np.array(response))

    def _groups(self) -> list[list[int]]:
        """Return the runs by what is asked of the structure: same drive points, as many motions."""
        groups: dict[tuple[tuple[Dof, ...], int], list[int]] = {}
        for i, run in enumerate(self.runs):
            groups.setdefault((run.shot.drives, len(run.motions)), []).append(i)
        return list(groups.values())

    def _receptance(self, runs: Sequence[Run], omega: FloatArray, top: float) -> ComplexArray:
        """Return the receptance of the motions of runs, drive points first, (n_run, n_freq, ., n_in)."""
        first = runs[0].system
        right = first.selection(runs[0].shot.drives)
        lefts = [first.selection(run.motions) for run in runs]
        systems = [run.system for run in runs]
        if all(system.mass is first.mass for system in systems):
            return attached_variants(systems, omega, lefts, right)
        # An effect rebuilt the structure from run to run: each brings its own modes.
        each = zip(systems, lefts, strict=True)
        return np.array([attached(s.base_modes(top).at(omega), s, left, right) for s, left in each])

    def poles(self) -> tuple[FloatArray, FloatArray]:
        """Return frequency and half the half-power bandwidth, Hz, of every run's resonances.

        Of structure and sources moving together, as the spectra have them; (n_run, n_modes) each.
        """
        top = self.setup.analyser.frequency_max
        found = []
        for run in self.runs:
            whole = run.system
            for drive in run.drives:
                whole = drive.attached_to(whole)
            found.append(whole.resonances(top))
        longest = max(len(frequencies) for frequencies, _ in found)
        padded = [np.pad(pair, ((0, 0), (0, longest - len(pair[0]))), mode="edge") for pair in found]
        frequencies, widths = np.array(padded).swapaxes(0, 1)
        return frequencies, widths


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
    for dof in (*setup.drives, *setup.responses):
        system.index(dof)
    noise = NoiseLevels()
    source = Source(EXCITATIONS[setup.analyser.excitation.kind].continuous)
    for effect in effects:
        noise, source = effect.on_noise(noise), effect.on_source(source)
    runs = tuple(_run(system, shot, effects) for shot in setup.shots)
    return Chain(setup, runs, noise, source, tuple(effects))


def _run(system: DynamicSystem, shot: Shot, effects: Sequence[Effect]) -> Run:
    drives = [Drive(dof) for dof in shot.drives]
    forces = [Channel.ideal(dof, force=True) for dof in shot.drives]
    responses = [Channel.ideal(dof) for dof in shot.outputs]
    for effect in effects:
        system = effect.on_system(system, shot)
        drives = [effect.on_drive(drive) for drive in drives]
        forces = [effect.on_channel(channel, system) for channel in forces]
        responses = [effect.on_channel(channel, system) for channel in responses]
    return Run(shot, system, tuple(drives), tuple(forces), tuple(responses))
