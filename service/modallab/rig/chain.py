"""Measuring chain: structure, rig and effects, as frequency responses of every run's channels."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.fe.condensation import condense_if_cheaper
from modallab.fe.receptance import attached
from modallab.fe.system import DynamicSystem
from modallab.fe.variants import attached_variants
from modallab.rig.cancellation import with_mass_cancelled
from modallab.rig.channel import Channel
from modallab.rig.channel_response import CACHED_RECEPTANCE, CachedReceptance, ChannelResponse
from modallab.rig.distortion import with_equivalent_linearisation, with_linearisation_of
from modallab.rig.drive import Drive, reaction, transmission
from modallab.rig.effect import EFFECTS, Effect, build
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.run import Run, filtered
from modallab.rig.settings import CHAIN
from modallab.rig.setup import AcquisitionRun, RigSetup
from modallab.rig.source import NoiseLevels, Source


def forces_on_structure(runs: Sequence[Run], omega: FloatArray, alpha: ComplexArray) -> ComplexArray:
    """Return the forces on the structure per source and per nonlinear force, (n_run, n_freq, n_w, n_w).

    Parameters
    ----------
    alpha
        (n_run, n_freq, n_motions, n_w) receptance, drive points and nonlinear forces first.
    """
    if all(run.drives == runs[0].drives for run in runs):
        return _forces_of_drives(runs[0].drives, omega, alpha)
    return np.array(
        [
            _forces_of_drives(run.drives, omega, receptance[None])[0]
            for run, receptance in zip(runs, alpha, strict=True)
        ]
    )


def _forces_of_drives(drives: tuple[Drive, ...], omega: FloatArray, alpha: ComplexArray) -> ComplexArray:
    n, n_w = len(drives), alpha.shape[-1]
    force_transmission = transmission(drives, omega, alpha[:, :, :n, :n])
    if n_w == n:
        return force_transmission
    reaction_forces = reaction(drives, omega, alpha[:, :, :n, :n]) @ alpha[:, :, :n, n:]
    forces = np.zeros((*alpha.shape[:2], n_w, n_w), complex)
    forces[:, :, :n, :n], forces[:, :, :n, n:] = force_transmission, -reaction_forces
    forces[:, :, np.arange(n, n_w), np.arange(n, n_w)] = 1.0
    return forces


@dataclass(frozen=True, eq=False)
class Chain:
    """The measuring chain: loaded structure, exciters, channels and noise of every run."""

    setup: RigSetup
    runs: tuple[Run, ...]
    noise: NoiseLevels
    source: Source
    effects: tuple[Effect, ...]  # all of them, in stage order

    @property
    def n_in(self) -> int:
        """Number of simultaneous sources."""
        return len(self.runs[0].drives)

    @property
    def local_rms(self) -> FloatArray | None:
        """(n_run, r) root mean square motions at the nonlinear forces, m or m/s; None if one is at rest."""
        rms = np.array([[force.rms for force in run.local_forces] for run in self.runs])
        return rms if rms.size and rms.all() else None

    @property
    def without_distortion(self) -> "Chain":
        """The chain with the equivalent linearisation of nonlinear forces alone."""
        if not self.runs[0].local_forces:
            return self
        return replace(self, runs=tuple(replace(run, local_forces=()) for run in self.runs))

    @property
    def overlap(self) -> float:
        """Share of a record that overlaps with the next one.

        Empty if the declared excitation is independent from record to record.
        """
        analyser = self.setup.analyser
        return analyser.overlap if EXCITATIONS[analyser.excitation.kind].continuous > 0 else 0.0

    def respond(self, freq: FloatArray) -> ChannelResponse:
        """Return the channels' response to the sources at `freq` (n_freq,) Hz."""
        return self.source_and_residual_response(freq)[0]

    def residual_response(self, freq: FloatArray) -> ChannelResponse:
        """Return the channels' response to the residual of each nonlinear force."""
        return self.source_and_residual_response(freq)[1]

    def source_and_residual_response(self, freq: FloatArray) -> tuple[ChannelResponse, ChannelResponse]:
        """Return both responses; one solution serves both."""
        response, n_in = self._responses(freq), self.n_in
        parts = (response.force, response.response, response.local_displacement)
        return (
            ChannelResponse(*(part[..., :n_in] for part in parts)),
            ChannelResponse(*(part[..., n_in:] for part in parts)),
        )

    def _responses(self, freq: FloatArray) -> ChannelResponse:
        """Return the responses to sources and to residual forces, concatenated."""
        top = float(freq.real.max())
        part = self._responses_of_block(freq[: CHAIN.frequency_block], top)
        if len(freq) <= CHAIN.frequency_block:
            return part
        firsts = (part.force, part.response, part.local_displacement)
        shapes = [(array.shape[0], len(freq), *array.shape[2:]) for array in firsts]
        force, response, displacement = (np.empty(shape, complex) for shape in shapes)
        for start in range(0, len(freq), CHAIN.frequency_block):
            block = slice(start, start + CHAIN.frequency_block)
            part = part if start == 0 else self._responses_of_block(freq[block], top)
            force[:, block], response[:, block], displacement[:, block] = (
                part.force,
                part.response,
                part.local_displacement,
            )
        return ChannelResponse(force, response, displacement)

    def _responses_of_block(self, freq: FloatArray, top: float) -> ChannelResponse:
        omega = 2 * np.pi * np.maximum(freq, CHAIN.dc_line_fraction * self.setup.analyser.spacing)
        n_in = self.n_in
        force: list[ComplexArray] = [np.zeros(0, complex)] * len(self.runs)
        response, displacement = list(force), list(force)
        for group in self._groups():
            runs = [self.runs[i] for i in group]
            alpha = self._receptance(runs, omega, top)
            forces_at_work = forces_on_structure(runs, omega, alpha)
            if forces_at_work.shape[-1] == 1:  # one product instead of a matrix product for every line
                accelerations = alpha * (-(omega**2)[:, None, None] * forces_at_work)
            else:
                accelerations = -(omega**2)[None, :, None, None] * (alpha @ forces_at_work)
            for place, i in enumerate(group):
                run = self.runs[i]
                response[i] = filtered(run.channel_motions(accelerations[place]), run.responses, omega)
                displacement[i] = accelerations[place][:, n_in : run.n_forces] / -(omega**2)[:, None, None]
                gauge_forces = filtered(forces_at_work[place, :, :n_in], run.forces, omega)
                force[i] = with_mass_cancelled(
                    gauge_forces, response[i], run.acquisition_run, self.setup.analyser.mass_cancellation
                )
        return ChannelResponse(np.array(force), np.array(response), np.array(displacement))

    def _groups(self) -> list[list[int]]:
        """Return the indices of runs with as many motions, which share a solution."""
        groups: dict[int, list[int]] = {}
        for i, run in enumerate(self.runs):
            groups.setdefault(len(run.motions), []).append(i)
        return list(groups.values())

    def _receptance(self, runs: Sequence[Run], omega: FloatArray, top: float) -> ComplexArray:
        """Return the receptance of the runs' motions to drive-point and nonlinear forces, m/N.

        Asked for again of structures that are loaded alike, as where effects are of channels, it is known.
        """
        cache, key = runs[0].system.cache, (len(runs[0].motions), omega.tobytes())
        latest = cache.get(CACHED_RECEPTANCE, key)
        if latest is not None and latest.matches(runs):
            return latest.alpha
        alpha = self._solve_receptance(runs, omega, top)
        blocks = max(1, CHAIN.cached_receptances // alpha.size)
        cache.put(CACHED_RECEPTANCE, CachedReceptance(tuple(runs), alpha), key, capacity=blocks)
        return alpha

    def _solve_receptance(self, runs: Sequence[Run], omega: FloatArray, top: float) -> ComplexArray:
        first = runs[0].system
        inputs = [first.selection(run.motions[: run.n_forces]) for run in runs]
        outputs = [first.selection(run.motions) for run in runs]
        systems = [run.system for run in runs]
        if all(system.mass is first.mass for system in systems):
            return attached_variants(systems, omega, outputs, inputs)
        # An effect rebuilt the structure from run to run: each brings its own modes.
        condensed = [condense_if_cheaper(system, len(omega)) for system in systems]
        variants = zip(condensed, outputs, inputs, strict=True)
        return np.array([attached(s.base_modes(top).at(omega), s, *columns) for s, *columns in variants])

    def poles(self) -> tuple[FloatArray, FloatArray]:
        """Return frequency and half the half-power bandwidth, Hz, of every run's resonances.

        Of structure and sources moving together, as the spectra have them; (n_run, n_modes) each.
        """
        return self._poles

    @cached_property
    def _poles(self) -> tuple[FloatArray, FloatArray]:
        top = self.setup.analyser.frequency_max
        latest: dict[Hashable, tuple[FloatArray, FloatArray]] = {}
        resonances = []
        for run in self.runs:
            key = run.resonance_key  # runs of a roving hammer differ in their drive point alone
            if key not in latest:
                latest[key] = run.resonances(top)
            resonances.append(latest[key])
        longest = max(len(frequencies) for frequencies, _ in resonances)
        padded = [np.pad(pair, ((0, 0), (0, longest - len(pair[0]))), mode="edge") for pair in resonances]
        frequencies, widths = np.array(padded).swapaxes(0, 1)
        return frequencies, widths


def all_effects(setup: RigSetup, added: Sequence[Effect]) -> list[Effect]:
    """Return implied, declared and added effects, in stage order."""
    implied = [effect for cls in EFFECTS.values() for effect in cls.from_setup(setup)]
    declared = [build(spec) for spec in setup.effects]

    def order(effect: Effect) -> tuple[int, bool, bool]:
        # What acts everywhere comes first: a member's own factor multiplies what holds for all members.
        # Before it what all runs have in common, which is worked out once.
        return effect.stage, not effect.same_in_all_runs, effect.at is not None

    return sorted([*implied, *declared, *added], key=order)


def chain(
    system: DynamicSystem,
    setup: RigSetup,
    added: Sequence[Effect] = (),
    *,
    same_in_all_runs: bool = False,
    initial_rms: FloatArray | None = None,
    linearised: Sequence[Run] | None = None,
    only: Sequence[int] | None = None,
) -> Chain:
    """Return the measuring chain of a system on a rig.

    Parameters
    ----------
    system
        The structure, bare.
    setup
        Its analyser's lines are all of those from 0 Hz on, in the chain.
    added
        Effects beside those of the declared hardware.
    same_in_all_runs, initial_rms
        Whether nonlinear forces take the same motion in every run, and what they take in a chain very
        much like it, as `with_equivalent_linearisation`.
    linearised
        Runs of a chain very much like it, whose equivalent linearisation is taken as it is.
    only
        Indices of the runs that the chain has; None: all of the log book.

    Raises
    ------
    UnknownDofError
        If the structure lacks a DoF that the rig drives or listens at.
    """
    setup = setup.baseband
    effects = all_effects(setup, added)
    for dof in (*setup.drives, *setup.responses):
        system.index(dof)
    noise = NoiseLevels()
    source = Source(EXCITATIONS[setup.analyser.excitation.kind].continuous)
    for effect in effects:
        noise, source = effect.on_noise(noise), effect.on_source(source)
    declared = setup.acquisition_runs if only is None else [setup.acquisition_runs[i] for i in only]
    for effect in effects:
        if effect.same_in_all_runs:
            system = effect.on_system(system, declared[0])
    system = system.with_loss_of_altered_modes()
    active_effects = [(effect, stages) for effect in effects if any(stages := _acts_on_runs(effect))]
    drives_of = lru_cache(partial(_with_effects, effects))  # the same in every run of a roving accelerometer
    runs = tuple(
        _run(system, acquisition_run, drives_of(acquisition_run.drives), active_effects)
        for acquisition_run in _true_runs(declared, effects)
    )
    if local := [force for effect in effects if (force := effect.on_motion()) is not None]:
        runs = (
            with_equivalent_linearisation(
                runs,
                local,
                setup.analyser,
                source,
                same_in_all_runs=same_in_all_runs,
                initial_rms=initial_rms,
            )
            if linearised is None
            else with_linearisation_of(runs, linearised)
        )
    return Chain(setup, runs, noise, source, tuple(effects))


def _true_runs(declared: Sequence[AcquisitionRun], effects: Sequence[Effect]) -> Sequence[AcquisitionRun]:
    """Return the runs with each accelerometer at its true point."""
    runs = list(declared)
    for effect in effects:
        if type(effect).on_run is not Effect.on_run:
            runs = [effect.on_run(run) for run in runs]
    return runs


def _with_effects(effects: Sequence[Effect], dofs: tuple[Dof, ...]) -> tuple[Drive, ...]:
    """Return the exciters at some drive points with all effects."""
    drives = [Drive(dof) for dof in dofs]
    for effect in effects:
        if type(effect).on_drive is not Effect.on_drive:
            drives = [effect.on_drive(drive) for drive in drives]
    return tuple(drives)


def _acts_on_runs(effect: Effect) -> tuple[bool, bool]:
    """Return whether an effect acts on single runs by `on_system`, and by `on_channel`."""
    kind = type(effect)
    return (
        kind.on_system is not Effect.on_system and not effect.same_in_all_runs,
        kind.on_channel is not Effect.on_channel,
    )


def _run(
    system: DynamicSystem,
    acquisition_run: AcquisitionRun,
    drives: tuple[Drive, ...],
    effects: Sequence[tuple[Effect, tuple[bool, bool]]],
) -> Run:
    """Return one run with all effects on a structure that has those that are the same in all runs."""
    forces = [Channel.ideal(dof, force=True) for dof in acquisition_run.drives]
    responses = [Channel.ideal(dof) for dof in acquisition_run.outputs]
    for effect, (to_system, to_channel) in effects:
        if to_system:
            system = effect.on_system(system, acquisition_run)
        if to_channel:
            forces = [effect.on_channel(channel, system) for channel in forces]
            responses = [effect.on_channel(channel, system) for channel in responses]
    return Run(acquisition_run, system, drives, tuple(forces), tuple(responses))
