"""What hangs on a structure at any of its places, foreseen in closed form: no prediction for each place."""

from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray, logarithm
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import logarithm_weight, residual
from modallab.diagnosis.searching.attached_stiffness import AttachedStiffness
from modallab.fe.attachment import Attachment
from modallab.fe.receptance import attached, solve_small
from modallab.fe.receptance_map import ReceptanceMap
from modallab.rig.effect import Effect
from modallab.rig.run import Run
from modallab.rig.settings import CHAIN

FAINT = 1e-12  # share of a difference, beside a logarithm, that is left out
SLIGHT = 1e-6  # share of an exchange over which residuals are differentiated
Exchange = tuple[Attachment | None, Attachment | None]  # what comes, and what goes for it


class ModificationScreen:
    """How FRFs change with one effect more, from the receptances of the loaded structure alone.

    alpha' / alpha = 1 - alpha_oB (I + Z alpha_BB)^-1 Z alpha_Bd / alpha_od, the Woodbury identity: one
    solution for all sizes of an effect at a place. Exact for the FRFs at the lines; leakage, noise and
    the force spectrum are taken to stay as they are, which is enough to choose places by.
    """

    def __init__(self, glimpses: CoarsePrediction, accepted: Sequence[Effect]) -> None:
        self._tests = [_Test(test, accepted) for test in glimpses.predictor.tests]
        self._observed, self._placed = glimpses.observed, glimpses.predictor.stack_channels
        self._base = glimpses.predict(accepted)
        self._left = residual(glimpses.observed, self._base)
        self._frf = _Whitened(glimpses.observed, self._base.h)
        self._places = self._split()

    def _split(self) -> list[tuple[IntArray, IntArray]]:
        """Return for each test which entries of a ratio are its own, and where it has them."""
        ends = np.cumsum([0, *(test.size for test in self._tests)])
        each = [
            np.arange(start, start + test.size).reshape(len(test.omega), -1)
            for start, test in zip(ends, self._tests, strict=False)
        ]
        number = np.asarray(self._placed(each, -1)).ravel()[self._frf.place]
        mine = [np.flatnonzero((number >= low) & (number < high)) for low, high in pairwise(ends)]
        return [(own, number[own] - low) for own, low in zip(mine, ends, strict=False)]

    @cached_property
    def unmodified(self) -> FloatArray:
        """The whitened residuals (n_residuals,) without any effect; see `vectors`."""
        return self._left.vector(self._observed.fitted)

    def ratios(self, variants: Sequence[Effect]) -> ComplexArray | None:
        """Return the FRFs with each effect over those without.

        Parameters
        ----------
        variants
            One kind of effect at one place, in several sizes.

        Returns
        -------
        (n_variants, n_fitted) at the lines and channels that a fit sees, or None if they do more to a
        structure than hang on it.
        """
        whole = np.ones((len(variants), len(self._frf.place)), complex)
        for test, (own, places) in zip(self._tests, self._places, strict=True):
            ratios = test.ratios(variants, places)
            if ratios is None:
                return None
            whole[:, own] = ratios
        return whole

    def vectors(self, ratios: ComplexArray) -> FloatArray:
        """Return the whitened residuals of FRFs so many times as large, all else as without the effect.

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
        """Return how the whitened residuals change with a share of each exchange on the model.

        alpha'/alpha = 1 - s alpha_oB Z alpha_Bd / alpha_od to first order in the share s.

        Parameters
        ----------
        exchanged
            The same in every run.

        Returns
        -------
        (n_residuals, n_exchanged), in the order of `Residual.vector`.
        """
        each = [test.derivatives(exchanged) for test in self._tests]
        ratios = np.asarray(self._placed([1 + SLIGHT * change for change in each], 1.0))
        fitted = ratios.reshape(len(ratios), -1)[:, self._frf.place]
        return np.asarray((self.vectors(fitted) - self.unmodified).T / SLIGHT)


class _Whitened:
    """Residuals of the FRFs that a fit sees, for many predictions at once; see `residual.apart`."""

    def __init__(self, observed: Observed, h: ComplexArray) -> None:
        where = observed.fitted
        self.place = np.flatnonzero(where)
        self._ratio = (observed.h / np.where(observed.usable, h, 1.0))[where]
        error = observed.error[where]
        self._logarithm = logarithm_weight(observed.error)[where]
        self._differing = np.flatnonzero(1 - self._logarithm > FAINT)
        self._bias = np.broadcast_to(observed.bias, where.shape)[where]
        common = np.zeros_like(error) if observed.shared_noise is None else observed.shared_noise[where]
        rest = np.sqrt(1 - common)
        self._error, self._along = error * rest, np.sqrt(common) / rest
        # What channels of a line have in common is taken once, see `Residual.vector`.
        self._count = where.sum(axis=1)[where.any(axis=1)]
        self._start = np.concatenate([[0], np.cumsum(self._count)[:-1]]).astype(int)
        size = np.add.reduceat(self._along**2, self._start) if len(error) else np.zeros(0)
        self._less = (1 - 1 / np.sqrt(1 + size)) / np.maximum(size, 1e-300)

    def of(self, ratios: ComplexArray) -> ComplexArray:
        """Return residuals (n, n_fitted) of FRFs so many times as large, (n, n_fitted)."""
        ratio = self._ratio / ratios
        apart = logarithm(ratio)
        apart -= self._bias
        apart *= self._logarithm
        some = self._differing
        apart[:, some] += (1 - self._logarithm[some]) * (1 - 1 / ratio[:, some])
        apart /= self._error
        if self._along.any():
            both = self._less * np.add.reduceat(self._along * apart, self._start, axis=1)
            apart -= np.repeat(both, self._count, axis=1) * self._along
        return apart


class _Test:
    """The runs of one test, loaded as they are without the effect."""

    def __init__(self, predictor: SingleTestPredictor, accepted: Sequence[Effect]) -> None:
        analyser = predictor.setup.analyser
        freq = analyser.freq[:: predictor.step]
        self._runs = predictor.chain(accepted).runs
        self.omega = 2 * np.pi * np.maximum(freq, CHAIN.dc_line_fraction * analyser.spacing)
        self._hanging = AttachedStiffness(self._runs[0], self.omega)
        self._reaches = [_reach(runs, self.omega) for runs in _alike(self._runs)]
        first = [run.system.selection(run.acquisition_run.drives[:1]) for run in self._runs]
        self._direct = self._receptances(first)[0][..., 0]

    @property
    def size(self) -> int:
        """How many FRFs at how many lines there are, together."""
        return int(self._direct.size)

    def ratios(self, variants: Sequence[Effect], places: IntArray) -> ComplexArray | None:
        """Return the ratios (n_variants, n_places); None where the effect alters the matrices.

        Parameters
        ----------
        places
            Where they are wanted, of the entries (n_lines, n_run n_out) counted line by line.
        """
        hung = self._hanging.of(variants)
        if hung is None:
            return None
        columns, z = hung[0], hung[1][:, None]
        to_b, within, from_b = self._receptances([columns] * len(self._runs))
        # z (n_variants, 1, n_lines, r, r) against (n_run, n_lines, ...): every size in every run.
        if z.shape[-1] == 1:  # without a call for every line
            inner, force = z * within, z * from_b
        else:
            inner, force = z @ within, z @ from_b
        inner[..., np.arange(z.shape[-1]), np.arange(z.shape[-1])] += 1.0
        carried = solve_small(inner, force)[..., 0]
        line, run, out = np.unravel_index(places, np.moveaxis(self._direct, 0, 1).shape)
        there, direct = to_b[run, line, out], self._direct[run, line, out]
        # Motion by motion: matrix products of so few would be a call for every line.
        change = sum(there[:, i] * carried[..., i][:, run, line] for i in range(z.shape[-1]))
        return np.asarray(1 - change / direct)

    def derivatives(self, exchanged: Sequence[Exchange]) -> ComplexArray:
        """Return the relative changes (n_exchanged, n_lines, n_out), each for a whole exchange."""
        heard, driven, direct = self._everywhere()
        change = np.zeros((len(exchanged), *direct.shape), complex)
        for i, (comes, goes) in enumerate(exchanged):
            for sign, a in ((-1, comes), (1, goes)):
                if a is not None:
                    rows = len(a.columns)
                    z, motion = a.dynamic_stiffness(self.omega), driven[..., :rows] @ a.columns
                    force = np.einsum("fij,rfj->rfi", z, motion)
                    change[i] += sign * ((heard[..., :rows] @ a.columns) @ force[..., None])[..., 0] / direct
        return np.moveaxis(change, 1, 2).reshape(len(exchanged), len(self.omega), -1)

    def _everywhere(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return alpha_oX (n_run, n_lines, n_out, n) of all DoFs, alpha_dX (.., n), alpha_od (.., n_out)."""
        alpha = []
        for run in self._runs:
            drive = run.system.selection(run.acquisition_run.drives[:1])
            left = np.hstack([run.system.selection(run.motions), drive])
            right = np.hstack([drive, np.eye(len(drive))])
            response = run.system.base_modes(float(self.omega.max()) / (2 * np.pi)).at(self.omega)
            alpha.append(attached(response, run.system, left, right))
        heard = np.array(
            [run.channel_motions(own[:, :-1]) for run, own in zip(self._runs, alpha, strict=True)]
        )
        return heard[..., 1:], np.array([own[:, -1, 1:] for own in alpha]), heard[..., 0]

    def _receptances(self, columns: Sequence[FloatArray]) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return alpha_oB (n_run, n_lines, n_out, r), alpha_BB and alpha_Bd (.., r, 1).

        Parameters
        ----------
        columns
            (n, r) of every run, the same in runs of one reach.
        """
        alpha: list[ComplexArray] = []
        within: list[ComplexArray] = []
        for reach in self._reaches:
            to_b, own = reach.to(columns[len(alpha)])
            alpha += list(to_b)
            within += list(own)
        heard = [run.channel_motions(own) for run, own in zip(self._runs, alpha, strict=True)]
        from_b = [own[:, :1].swapaxes(1, 2) for own in alpha]
        return np.array(heard), np.array(within), np.array(from_b)


def _alike(runs: Sequence[Run]) -> list[Sequence[Run]]:
    """Return runs by what they share of a solution: all, or none."""
    first = runs[0]
    alike = all(
        run.system.mass is first.system.mass
        and run.acquisition_run.drives == first.acquisition_run.drives
        and len(run.motions) == len(first.motions)
        for run in runs
    )
    return [runs] if alike else [[run] for run in runs]


def _reach(runs: Sequence[Run], omega: FloatArray) -> ReceptanceMap:
    return ReceptanceMap(
        [run.system for run in runs], omega, [run.system.selection(run.motions) for run in runs]
    )
