"""Effects predicted in closed form: modifications of the structure, filters of channels, exciters."""

from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray, logarithm
from modallab.core.numerics import PRODUCT_ROUNDING, SAFE_DIVISOR
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.residuals.normalised_difference import logarithm_weight
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import residual
from modallab.diagnosis.searching.run_receptances import Exchange, RunReceptances
from modallab.diagnosis.searching.scan_settings import SCREENING
from modallab.rig.effect import Effect


class ModificationScreen:
    """Structural modification of FRFs by one additional effect, from receptances without it.

    alpha' / alpha = 1 - alpha_oB (I + Z alpha_BB)^-1 Z alpha_Bd / alpha_od, the Woodbury identity: one
    solution for all values of an effect at a place. Exact for the FRFs at the lines; leakage, noise and
    the force spectrum are taken as unchanged, which is accurate enough to rank places.
    """

    def __init__(self, prediction: CoarsePrediction, accepted: Sequence[Effect]) -> None:
        self._tests = [
            RunReceptances(test, accepted, test.coarse_lines) for test in prediction.predictor.tests
        ]
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
        (n_variants, n_fitted) at the fitted lines and channels, or None if the effect does more than attach
        stiffness, damping or mass to the structure, and filter channels.
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

    def residuals(self, variants: Sequence[Effect]) -> FloatArray | None:
        """Return the whitened residuals (n_variants, n_residuals) with each effect; None without closed form.

        Parameters
        ----------
        variants
            One kind of effect at one place, in several sizes.
        """
        ratios = self.ratios(variants)
        return self._with_forces(variants) if ratios is None else self.vectors(ratios)

    def _with_forces(self, variants: Sequence[Effect]) -> FloatArray | None:
        """Return the whitened residuals with the exciters of each effect; the level of a source follows."""
        residual, power = self._residual, self._observed.source_power
        # Tests of one structure have their forces in an order of their own.
        ratios = self._tests[0].force_ratios(variants) if len(self._tests) == 1 else None
        if residual.force is None or ratios is None:
            return None
        logarithms = np.log(ratios)
        if self._observed.free_levels.source and power is not None:
            logarithms -= power.project(logarithms)
        changes = -logarithms / np.sqrt(residual.force_variance)
        changes = changes[:, residual.mask_of("force", self._observed.fitted)]
        vectors = np.tile(self.unmodified, (len(variants), 1))
        start = 2 * len(self._frf.place)
        vectors[:, start : start + changes.shape[1]] += changes
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
