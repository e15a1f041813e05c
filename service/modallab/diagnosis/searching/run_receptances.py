"""Receptances of the runs of a test, from which structural modifications follow in closed form."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.place import Channels
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.searching.attached_stiffness import AttachedStiffness
from modallab.diagnosis.searching.closed_form import (
    changes_drives_alone,
    changes_frfs_alone,
    filters_channels,
    transfer_ratios,
)
from modallab.fe.attachment import Attachment
from modallab.fe.receptance import attached
from modallab.fe.receptance_map import ReceptanceMap
from modallab.fe.small_systems import solve_small
from modallab.rig.chain import forces_on_structure
from modallab.rig.effect import Effect
from modallab.rig.run import Run
from modallab.rig.settings import CHAIN


@dataclass(frozen=True, eq=False)
class Entries:
    """Entries of FRFs by the numbers of their lines, forces and responses, (n,) each."""

    line: IntArray
    force: IntArray
    out: IntArray

    def at(self, indices: IntArray) -> "Entries":
        """Return some of the entries, (m,) indices."""
        return Entries(self.line[indices], self.force[indices], self.out[indices])


Exchange = tuple[Attachment | None, Attachment | None]
"""An attachment that is added, and the one that it replaces."""


class RunReceptances:
    """Receptances of the runs of one test, with the transducers but without an additional effect.

    Parameters
    ----------
    accepted
        Effects that act in every prediction.
    lines
        (n_lines,) indices of the lines from 0 Hz on.
    """

    def __init__(self, predictor: SingleTestPredictor, accepted: Sequence[Effect], lines: IntArray) -> None:
        analyser = predictor.setup.baseband.analyser
        freq = analyser.freq[lines]
        self._runs = predictor.chain(accepted).runs
        self.omega = 2 * np.pi * np.maximum(freq, CHAIN.dc_line_fraction * analyser.spacing)
        self._attached_in = [AttachedStiffness(run, self.omega) for run in self._runs]
        self._maps = [_receptance_map(runs, self.omega) for runs in _solution_groups(self._runs)]
        drives = [len(run.acquisition_run.drives) for run in self._runs]
        self._runs_of_forces = np.repeat(np.arange(len(drives)), drives)
        self.direct = self._direct_receptances()
        self._mass_cancelled = analyser.mass_cancellation > 0  # of a reading, which is subtracted

    @property
    def size(self) -> int:
        """Number of FRFs times number of lines."""
        return int(self.direct.size)

    def ratios(self, variants: Sequence[Effect], places: IntArray) -> ComplexArray | None:
        """Return the ratios (n_variants, n_places) of FRFs with each effect to those without.

        None where the effect alters the matrices, or does more than to attach to the structure and to filter
        channels.

        Parameters
        ----------
        variants
            One kind of effect at one place, in several sizes.
        places
            Indices of entries (n_lines, n_force n_out), counted line by line.
        """
        if not changes_frfs_alone(variants[0]) or (self._mass_cancelled and filters_channels(variants[0])):
            return None
        entries = Entries(*np.unravel_index(places, np.moveaxis(self.direct, 0, 1).shape))
        if not variants[0].same_in_all_runs:
            return self._ratios_run_by_run(variants, entries)
        stiffness = self._attached_in[0].of(variants)
        if stiffness is None or not stiffness[0].shape[1]:
            return None
        return self._structural_ratios(*stiffness, entries)

    def _structural_ratios(self, columns: FloatArray, z: ComplexArray, entries: Entries) -> ComplexArray:
        """Return the ratios (n_variants, n_entries) with dynamic stiffness `z` attached to motions."""
        to_b, within, from_b = self.receptances(columns)
        z = z[:, None]
        # z (n_variants, 1, n_lines, r, r) against (n_force, n_lines, ...): every size for every force.
        if z.shape[-1] == 1:  # without a call for every line
            inner, force = z * within, z * from_b
        else:
            inner, force = z @ within, z @ from_b
        inner[..., np.arange(z.shape[-1]), np.arange(z.shape[-1])] += 1.0
        forces = solve_small(inner, force)[..., 0]
        line, number, out = entries.line, entries.force, entries.out
        alpha, direct = to_b[number, line, out], self.direct[number, line, out]
        # Motion by motion: matrix products of so few would be a call for every line.
        change = sum(alpha[:, i] * forces[..., i][:, number, line] for i in range(z.shape[-1]))
        return np.asarray(1 - change / direct)

    def _ratios_run_by_run(self, variants: Sequence[Effect], entries: Entries) -> ComplexArray | None:
        """Return the ratios (n_variants, n_entries) of an effect that acts on each run in its own way."""
        all_ratios = np.ones((len(variants), len(entries.line)), complex)
        for i, run in enumerate(self._runs):
            if not _concerns(variants[0], run):
                continue
            stiffness = self._attached_in[i].of(variants)
            transfers = transfer_ratios(run, variants, self.omega)
            if stiffness is None or transfers is None:
                return None
            of_run = np.flatnonzero(self._runs_of_forces[entries.force] == i)
            here = entries.at(of_run)
            if stiffness[0].shape[1]:
                all_ratios[:, of_run] *= self._structural_ratios(*stiffness, here)
            all_ratios[:, of_run] *= transfers[:, here.line, here.out]
        return None if (all_ratios == 1).all() else all_ratios

    def force_ratios(self, variants: Sequence[Effect]) -> FloatArray | None:
        """Return the ratios (n_variants, n_lines, n_force) of force spectra with and without each effect.

        None where the effect does more than to change the exciters.
        """
        if not changes_drives_alone(variants[0]):
            return None

        def powers(effect: Effect | None) -> FloatArray:
            runs = self._runs if effect is None else [_with_exciters_of(effect, run) for run in self._runs]
            power = (np.abs(forces_on_structure(runs, self.omega, self._at_drives)) ** 2).sum(axis=3)
            return np.asarray(np.moveaxis(power, 0, 1).reshape(len(self.omega), -1))

        unmodified = powers(None)
        return np.array([powers(effect) / unmodified for effect in variants])

    @cached_property
    def _at_drives(self) -> ComplexArray:
        """(n_run, n_lines, n_in, n_in): receptances of the drive points of each run, m/N."""
        n_in = len(self._runs[0].acquisition_run.drives)
        by_run = []
        for i, run in enumerate(self._runs):
            columns = run.system.selection(run.acquisition_run.drives)
            by_run.append(self._motions(columns)[0][i][:, :n_in])
        return np.array(by_run)

    def derivatives(self, exchanged: Sequence[Exchange]) -> ComplexArray:
        """Return the relative changes (n_exchanged, n_lines, n_out), each for a whole exchange."""
        to_outputs, from_drive, direct = self._all_receptances()
        change = np.zeros((len(exchanged), *direct.shape), complex)
        for i, (added, removed) in enumerate(exchanged):
            for sign, a in ((-1, added), (1, removed)):
                if a is not None:
                    rows = len(a.columns)
                    z, motion = a.dynamic_stiffness(self.omega), from_drive[..., :rows] @ a.columns
                    force = np.einsum("fij,rfj->rfi", z, motion)
                    change[i] += (
                        sign * ((to_outputs[..., :rows] @ a.columns) @ force[..., None])[..., 0] / direct
                    )
        return np.moveaxis(change, 1, 2).reshape(len(exchanged), len(self.omega), -1)

    def _all_receptances(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return alpha_oX (n_force, n_lines, n_out, n) of all DoFs, alpha_dX (.., n) and alpha_od."""
        to_outputs, from_drive, direct = [], [], []
        for run in self._runs:
            drives = run.system.selection(run.acquisition_run.drives)
            n_in = drives.shape[1]
            rows = np.hstack([run.system.selection(run.motions), drives])
            columns = np.hstack([drives, np.eye(len(drives))])
            response = run.system.base_modes(float(self.omega.max()) / (2 * np.pi)).at(self.omega)
            alpha = attached(response, run.system, rows, columns)
            run_outputs = run.channel_motions(alpha[:, :-n_in])
            for i in range(n_in):
                to_outputs.append(run_outputs[..., n_in:])
                from_drive.append(alpha[:, i - n_in, n_in:])
                direct.append(run_outputs[..., i])
        return np.array(to_outputs), np.array(from_drive), np.array(direct)

    def _direct_receptances(self) -> ComplexArray:
        """Return alpha_od (n_force, n_lines, n_out) from each drive point to the responses of its run."""
        runs = [run for run in self._runs for _ in run.acquisition_run.drives]
        drives = [drive for run in self._runs for drive in run.acquisition_run.drives]
        direct = {
            drive: self.receptances(runs[drives.index(drive)].system.selection((drive,)))[0][..., 0]
            for drive in dict.fromkeys(drives)
        }
        return np.array([direct[drive][i] for i, drive in enumerate(drives)])

    def receptances(self, columns: FloatArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return alpha_oB (n_force, n_lines, n_out, r), alpha_BB and alpha_Bd (.., r, 1) of r columns."""
        alpha, within = self._motions(columns)
        to_outputs = [run.channel_motions(block) for run, block in zip(self._runs, alpha, strict=True)]
        # The motions of a run begin with those of its drive points.
        of_force = [
            (i, d) for i, run in enumerate(self._runs) for d in range(len(run.acquisition_run.drives))
        ]
        return (
            np.array([to_outputs[i] for i, _ in of_force]),
            np.array([within[i] for i, _ in of_force]),
            np.array([alpha[i][:, d : d + 1].swapaxes(1, 2) for i, d in of_force]),
        )

    def _motions(self, columns: FloatArray) -> tuple[list[ComplexArray], list[ComplexArray]]:
        """Return by run the receptances (n_lines, n_motions, r) of its motions from columns, and alpha_BB."""
        alpha: list[ComplexArray] = []
        within: list[ComplexArray] = []
        for receptance_map in self._maps:
            to_b, block = receptance_map.to(columns)
            alpha += list(to_b)
            within += list(block)
        return alpha, within


def _with_exciters_of(effect: Effect, run: Run) -> Run:
    return replace(run, drives=tuple(effect.on_drive(drive) for drive in run.drives))


def _concerns(effect: Effect, run: Run) -> bool:
    """Return whether an effect may act in a run: one of channels in those that measure them."""
    measured = run.acquisition_run.outputs
    return not isinstance(effect.at, Channels) or any(effect.acts_on(dof) for dof in measured)


def _solution_groups(runs: Sequence[Run]) -> list[Sequence[Run]]:
    """Return the runs in groups of one solution each: all together, or one by one."""
    first = runs[0]
    equal = all(
        run.system.mass is first.system.mass and len(run.motions) == len(first.motions) for run in runs
    )
    return [runs] if equal else [[run] for run in runs]


def _receptance_map(runs: Sequence[Run], omega: FloatArray) -> ReceptanceMap:
    return ReceptanceMap(
        [run.system for run in runs], omega, [run.system.selection(run.motions) for run in runs]
    )
