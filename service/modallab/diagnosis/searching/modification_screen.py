"""Structural modifications at any place, predicted in closed form from the receptances."""

from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray, logarithm
from modallab.core.numerics import PRODUCT_ROUNDING, SAFE_DIVISOR
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import logarithm_weight, residual
from modallab.diagnosis.searching.attached_stiffness import AttachedStiffness
from modallab.diagnosis.searching.settings import SCREENING
from modallab.fe.attachment import Attachment
from modallab.fe.receptance import attached, solve_small
from modallab.fe.receptance_map import ReceptanceMap
from modallab.rig.effect import Effect
from modallab.rig.run import Run
from modallab.rig.settings import CHAIN

Exchange = tuple[Attachment | None, Attachment | None]
"""An attachment that is added, and the one that it replaces."""


class ModificationScreen:
    """Structural modification of FRFs by one additional effect, from receptances without it.

    alpha' / alpha = 1 - alpha_oB (I + Z alpha_BB)^-1 Z alpha_Bd / alpha_od, the Woodbury identity: one
    solution for all values of an effect at a place. Exact for the FRFs at the lines; leakage, noise and
    the force spectrum are taken as unchanged, which is accurate enough to rank places.
    """

    def __init__(self, prediction: CoarsePrediction, accepted: Sequence[Effect]) -> None:
        self._tests = [_TestReceptances(test, accepted) for test in prediction.predictor.tests]
        self._observed, self._placed = prediction.observed, prediction.predictor.stack_channels
        self._base = prediction.predict(accepted)
        self._residual = residual(prediction.observed, self._base)
        self._frf = _WhitenedFrfs(prediction.observed, self._base.h)
        self._places = self._split()

    def _split(self) -> list[tuple[IntArray, IntArray]]:
        """Return for each test the indices of its entries in a ratio, and their indices in the test."""
        ends = np.cumsum([0, *(test.size for test in self._tests)])
        indices = [
            np.arange(start, start + test.size).reshape(len(test.omega), -1)
            for start, test in zip(ends, self._tests, strict=False)
        ]
        number = np.asarray(self._placed(indices, -1)).ravel()[self._frf.place]
        entries = [np.flatnonzero((number >= low) & (number < high)) for low, high in pairwise(ends)]
        return [(entry, number[entry] - low) for entry, low in zip(entries, ends, strict=False)]

    @cached_property
    def unmodified(self) -> FloatArray:
        """The whitened residuals (n_residuals,) without any effect; see `vectors`."""
        return self._residual.vector(self._observed.fitted)

    def ratios(self, variants: Sequence[Effect]) -> ComplexArray | None:
        """Return the ratio of FRFs with each effect to those without.

        Parameters
        ----------
        variants
            One kind of effect at one place, in several sizes.

        Returns
        -------
        (n_variants, n_fitted) at the fitted lines and channels, or None if the effect does more to a
        structure than attach stiffness, damping or mass.
        """
        all_ratios = np.ones((len(variants), len(self._frf.place)), complex)
        for test, (entries, places) in zip(self._tests, self._places, strict=True):
            ratios = test.ratios(variants, places)
            if ratios is None:
                return None
            all_ratios[:, entries] = ratios
        return all_ratios

    def vectors(self, ratios: ComplexArray) -> FloatArray:
        """Return the whitened residuals with FRFs multiplied by ratios, all else as without the effect.

        Parameters
        ----------
        ratios
            (n_variants, n_fitted), as `ratios`.

        Returns
        -------
        (n_variants, n_residuals), in the order of `Residual.vector`.
        """
        frf, n = self._frf.of(ratios), ratios.shape[1]
        vectors = np.empty((len(frf), len(self.unmodified)))
        vectors[:, :n], vectors[:, n : 2 * n] = frf.real, frf.imag
        vectors[:, 2 * n :] = self.unmodified[2 * n :]  # of force and incoherent responses
        return vectors

    def derivatives(self, exchanged: Sequence[Exchange]) -> FloatArray:
        """Return the derivatives of the whitened residuals by a share of each exchange on the model.

        alpha'/alpha = 1 - s alpha_oB Z alpha_Bd / alpha_od to first order in the share s.

        Parameters
        ----------
        exchanged
            The same in every run.

        Returns
        -------
        (n_residuals, n_exchanged), in the order of `Residual.vector`.
        """
        step = SCREENING.difference_step
        changes = [test.derivatives(exchanged) for test in self._tests]
        ratios = np.asarray(self._placed([1 + step * change for change in changes], 1.0))
        fitted = ratios.reshape(len(ratios), -1)[:, self._frf.place]
        return np.asarray((self.vectors(fitted) - self.unmodified).T / step)


class _WhitenedFrfs:
    """Residuals of the fitted FRFs, for many predictions at once; see `normalised_difference`."""

    def __init__(self, observed: Observed, h: ComplexArray) -> None:
        mask = observed.fitted
        self.place = np.flatnonzero(mask)
        self._mask, self._decorrelation = mask, observed.decorrelation
        self._ratio = (observed.h / np.where(observed.usable, h, 1.0))[mask]
        error = observed.error[mask]
        self._logarithm = logarithm_weight(observed.error)[mask]
        self._differing = np.flatnonzero(1 - self._logarithm > PRODUCT_ROUNDING)
        self._bias = np.broadcast_to(observed.bias, mask.shape)[mask]
        common = np.zeros_like(error) if observed.shared_noise is None else observed.shared_noise[mask]
        remainder = np.sqrt(1 - common)
        self._error, self._shared = error * remainder, np.sqrt(common) / remainder
        # Noise of a force that channels share in a line is counted once, see `Residual.vector`.
        forces = observed.forces
        line_and_force = np.nonzero(mask)[0] * (forces[-1] + 1) + np.broadcast_to(forces, mask.shape)[mask]
        self._count = np.unique(line_and_force, return_counts=True)[1]
        self._start = np.concatenate([[0], np.cumsum(self._count)[:-1]]).astype(int)
        size = np.add.reduceat(self._shared**2, self._start) if len(error) else np.zeros(0)
        self._reduction = (1 - 1 / np.sqrt(1 + size)) / np.maximum(size, SAFE_DIVISOR)

    def of(self, ratios: ComplexArray) -> ComplexArray:
        """Return residuals (n, n_fitted) of FRFs multiplied by ratios (n, n_fitted)."""
        ratio = self._ratio / ratios
        difference = logarithm(ratio)
        difference -= self._bias
        difference *= self._logarithm
        differing = self._differing
        difference[:, differing] += (1 - self._logarithm[differing]) * (1 - 1 / ratio[:, differing])
        difference /= self._error
        if self._shared.any():
            common = self._reduction * np.add.reduceat(self._shared * difference, self._start, axis=1)
            difference -= np.repeat(common, self._count, axis=1) * self._shared
        return self._decorrelated(difference)

    def _decorrelated(self, difference: ComplexArray) -> ComplexArray:
        if self._decorrelation is None:
            return difference
        everywhere = np.zeros((len(difference), *self._mask.shape), complex)
        everywhere[:, self._mask] = difference
        return np.asarray(self._decorrelation.of_frfs(everywhere, self._mask)[:, self._mask])


class _TestReceptances:
    """The runs of one test, with the transducers but without the effect."""

    def __init__(self, predictor: SingleTestPredictor, accepted: Sequence[Effect]) -> None:
        analyser = predictor.setup.baseband.analyser
        freq = analyser.freq[predictor.coarse_lines]
        self._runs = predictor.chain(accepted).runs
        self.omega = 2 * np.pi * np.maximum(freq, CHAIN.dc_line_fraction * analyser.spacing)
        self._attached = AttachedStiffness(self._runs[0], self.omega)
        self._maps = [_receptance_map(runs, self.omega) for runs in _solution_groups(self._runs)]
        self._direct = self._direct_receptances()

    @property
    def size(self) -> int:
        """Number of FRFs times number of lines."""
        return int(self._direct.size)

    def ratios(self, variants: Sequence[Effect], places: IntArray) -> ComplexArray | None:
        """Return the ratios (n_variants, n_places); None where the effect alters the matrices.

        Parameters
        ----------
        places
            Indices of entries (n_lines, n_force n_out), counted line by line.
        """
        stiffness = self._attached.of(variants)
        if stiffness is None:
            return None
        columns, z = stiffness[0], stiffness[1][:, None]
        to_b, within, from_b = self._receptances(columns)
        # z (n_variants, 1, n_lines, r, r) against (n_force, n_lines, ...): every size for every force.
        if z.shape[-1] == 1:  # without a call for every line
            inner, force = z * within, z * from_b
        else:
            inner, force = z @ within, z @ from_b
        inner[..., np.arange(z.shape[-1]), np.arange(z.shape[-1])] += 1.0
        forces = solve_small(inner, force)[..., 0]
        line, force_number, out = np.unravel_index(places, np.moveaxis(self._direct, 0, 1).shape)
        alpha, direct = to_b[force_number, line, out], self._direct[force_number, line, out]
        # Motion by motion: matrix products of so few would be a call for every line.
        change = sum(alpha[:, i] * forces[..., i][:, force_number, line] for i in range(z.shape[-1]))
        return np.asarray(1 - change / direct)

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
            drive: self._receptances(runs[drives.index(drive)].system.selection((drive,)))[0][..., 0]
            for drive in dict.fromkeys(drives)
        }
        return np.array([direct[drive][i] for i, drive in enumerate(drives)])

    def _receptances(self, columns: FloatArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return alpha_oB (n_force, n_lines, n_out, r), alpha_BB and alpha_Bd (.., r, 1) of r columns."""
        alpha: list[ComplexArray] = []
        within: list[ComplexArray] = []
        for receptance_map in self._maps:
            to_b, block = receptance_map.to(columns)
            alpha += list(to_b)
            within += list(block)
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
