"""What hangs on a structure at any of its places, foreseen in closed form: no prediction for each place."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, logarithm
from modallab.diagnosis.observing.observed import Observed
from modallab.diagnosis.observing.residual import log_share, residual
from modallab.diagnosis.predicting.glimpses import Glimpses
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.fe.attachment import Attachment
from modallab.fe.reach import Reach
from modallab.fe.receptance import attached, solved
from modallab.rig.chain import NEARLY_STILL
from modallab.rig.effect import Effect
from modallab.rig.run import Run

ROUNDING = 1e-9  # of the largest singular value
SLIGHT = 1e-6  # share of an exchange over which residuals are differentiated
Exchange = tuple[Attachment | None, Attachment | None]  # what comes, and what goes for it


class Foreseen:
    """How FRFs change with one effect more, from the receptances of the loaded structure alone.

    alpha' / alpha = 1 - alpha_oB (I + Z alpha_BB)^-1 Z alpha_Bd / alpha_od, the Woodbury identity: one
    solution for all sizes of an effect at a place. Exact for the FRFs at the lines; leakage, noise and
    the force spectrum are taken to stay as they are, which is enough to choose places by.
    """

    def __init__(self, glimpses: Glimpses, accepted: Sequence[Effect]) -> None:
        self._tests = [_Test(test, accepted) for test in glimpses.predictor.tests]
        self._observed, self._placed = glimpses.observed, glimpses.predictor.placed
        self._base = glimpses.predict(accepted)
        self._left = residual(glimpses.observed, self._base)
        self._frf = _Whitened(glimpses.observed, self._base.h)

    @cached_property
    def nothing(self) -> FloatArray:
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
        (n_variants, n_lines, n_out), or None if they do more to a structure than hang on it.
        """
        found = [test.ratios(variants) for test in self._tests]
        known = [ratios for ratios in found if ratios is not None]
        return np.asarray(self._placed(known, 1.0)) if len(known) == len(found) else None

    def vectors(self, ratios: ComplexArray) -> FloatArray:
        """Return the whitened residuals of FRFs so many times as large, all else as without the effect.

        Parameters
        ----------
        ratios
            (n_variants, n_lines, n_out).

        Returns
        -------
        (n_variants, n_residuals), in the order of `Residual.vector`.
        """
        frf = self._frf.of(ratios)
        rest = self.nothing[frf.shape[1] :]  # of force and incoherent responses
        return np.hstack([frf, np.broadcast_to(rest, (len(frf), len(rest)))])

    def slopes(self, exchanged: Sequence[Exchange]) -> FloatArray:
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
        each = [test.slopes(exchanged) for test in self._tests]
        ratios = np.asarray(self._placed([1 + SLIGHT * change for change in each], 1.0))
        return np.asarray((self.vectors(ratios) - self.nothing).T / SLIGHT)


class _Whitened:
    """Residuals of the FRFs that a fit sees, for many predictions at once; see `residual.apart`."""

    def __init__(self, observed: Observed, h: ComplexArray) -> None:
        where = observed.fitted
        self._place = np.flatnonzero(where)
        self._ratio = (observed.h / np.where(observed.usable, h, 1.0))[where]
        error = observed.error[where]
        self._logarithm = log_share(observed.error)[where]
        self._bias = np.broadcast_to(observed.bias, where.shape)[where]
        common = np.zeros_like(error) if observed.common is None else observed.common[where]
        rest = np.sqrt(1 - common)
        self._error, self._along = error * rest, np.sqrt(common) / rest
        # What channels of a line have in common is taken once, see `Residual.vector`.
        self._count = where.sum(axis=1)[where.any(axis=1)]
        self._start = np.concatenate([[0], np.cumsum(self._count)[:-1]]).astype(int)
        size = np.add.reduceat(self._along**2, self._start) if len(error) else np.zeros(0)
        self._less = (1 - 1 / np.sqrt(1 + size)) / np.maximum(size, 1e-300)

    def of(self, ratios: ComplexArray) -> FloatArray:
        """Return residuals (n, n_residuals) of FRFs so many times as large, (n, n_lines, n_out)."""
        ratio = self._ratio / ratios.reshape(len(ratios), -1)[:, self._place]
        share = self._logarithm
        apart = (share * (logarithm(ratio) - self._bias) + (1 - share) * (1 - 1 / ratio)) / self._error
        if self._along.any():
            both = self._less * np.add.reduceat(self._along * apart, self._start, axis=1)
            apart -= np.repeat(both, self._count, axis=1) * self._along
        return np.hstack([apart.real, apart.imag])


class _Test:
    """The runs of one test, loaded as they are without the effect."""

    def __init__(self, predictor: Predictor, accepted: Sequence[Effect]) -> None:
        analyser = predictor.setup.analyser
        freq = analyser.freq[:: predictor.step]
        self._runs = predictor.chain(accepted).runs
        self._omega = 2 * np.pi * np.maximum(freq, NEARLY_STILL * analyser.spacing)
        self._reaches = [_reach(runs, self._omega) for runs in _alike(self._runs)]
        first = [run.system.selection(run.shot.drives[:1]) for run in self._runs]
        self._direct = self._receptances(first)[0][..., 0]

    def ratios(self, variants: Sequence[Effect]) -> ComplexArray | None:
        """Return (n_variants, n_lines, n_out); None where the effect alters the matrices."""
        hung = [_hung(self._runs[0], effect) for effect in variants]
        known = [own for own in hung if own is not None]
        if len(known) < len(hung) or not any(known):
            return None
        columns = _span(np.hstack([a.columns for own in known for a in own]))
        z = np.array([self._stiffness(own, columns) for own in known])[:, None]
        to_b, within, from_b = self._receptances([columns] * len(self._runs))
        # z (n_variants, 1, n_lines, r, r) against (n_run, n_lines, ...): every size in every run.
        inner = z @ within
        inner[..., np.arange(z.shape[-1]), np.arange(z.shape[-1])] += 1.0
        carried = solved(inner, z @ from_b)
        # Motion by motion: matrix products of so few would be a call for every line.
        change = sum(to_b[..., i] * carried[..., i, :] for i in range(z.shape[-1]))
        return np.moveaxis(1 - change / self._direct, 1, 2).reshape(len(hung), len(self._omega), -1)

    def slopes(self, exchanged: Sequence[Exchange]) -> ComplexArray:
        """Return the relative changes (n_exchanged, n_lines, n_out), each for a whole exchange."""
        heard, driven, direct = self._everywhere()
        change = np.zeros((len(exchanged), *direct.shape), complex)
        for i, (comes, goes) in enumerate(exchanged):
            for sign, a in ((-1, comes), (1, goes)):
                if a is not None:
                    rows = len(a.columns)
                    z, motion = a.dynamic_stiffness(self._omega), driven[..., :rows] @ a.columns
                    force = np.einsum("fij,rfj->rfi", z, motion)
                    change[i] += sign * ((heard[..., :rows] @ a.columns) @ force[..., None])[..., 0] / direct
        return np.moveaxis(change, 1, 2).reshape(len(exchanged), len(self._omega), -1)

    def _everywhere(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return alpha_oX (n_run, n_lines, n_out, n) of all DoFs, alpha_dX (.., n), alpha_od (.., n_out)."""
        alpha = []
        for run in self._runs:
            drive = run.system.selection(run.shot.drives[:1])
            left = np.hstack([run.system.selection(run.motions), drive])
            right = np.hstack([drive, np.eye(len(drive))])
            response = run.system.base_modes(float(self._omega.max()) / (2 * np.pi)).at(self._omega)
            alpha.append(attached(response, run.system, left, right))
        heard = np.array([run.mixed(own[:, :-1]) for run, own in zip(self._runs, alpha, strict=True)])
        return heard[..., 1:], np.array([own[:, -1, 1:] for own in alpha]), heard[..., 0]

    def _stiffness(self, own: Sequence[Attachment], basis: FloatArray) -> ComplexArray:
        """Return the dynamic stiffness of attachments in a basis (n, r) of their motions, (n_lines, r, r)."""
        total = np.zeros((len(self._omega), basis.shape[1], basis.shape[1]), complex)
        for a in own:
            seen = basis.T @ a.columns
            total += seen @ a.dynamic_stiffness(self._omega) @ seen.T
        return total

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
        heard = [run.mixed(own) for run, own in zip(self._runs, alpha, strict=True)]
        from_b = [own[:, :1].swapaxes(1, 2) for own in alpha]
        return np.array(heard), np.array(within), np.array(from_b)


def _alike(runs: Sequence[Run]) -> list[Sequence[Run]]:
    """Return runs by what they share of a solution: all, or none."""
    first = runs[0]
    alike = all(
        run.system.mass is first.system.mass
        and run.shot.drives == first.shot.drives
        and len(run.motions) == len(first.motions)
        for run in runs
    )
    return [runs] if alike else [[run] for run in runs]


def _reach(runs: Sequence[Run], omega: FloatArray) -> Reach:
    return Reach([run.system for run in runs], omega, [run.system.selection(run.motions) for run in runs])


def _span(columns: FloatArray) -> FloatArray:
    """Return an orthonormal basis (n, r) of columns that are many times the same few."""
    sides, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(sides[:, sizes > ROUNDING * sizes[0]])


def _hung(run: Run, effect: Effect) -> tuple[Attachment, ...] | None:
    """Return what an effect attaches to the structure of a run; None if it does anything else to it."""
    before, after = run.system, effect.on_system(run.system, run.shot)
    if after.mass is not before.mass or after.stiffness is not before.stiffness:
        return None
    known = {id(a) for a in before.attachments}
    own = tuple(a for a in after.attachments if id(a) not in known)
    return own if len(own) + len(known) == len(after.attachments) else None
