"""Expected spectra of a test, and the variance of their estimates."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.numerics import COHERENCE_ROUNDING
from modallab.diagnosis.residuals.random_error import RealOrComplex
from modallab.estimation.coherence import coherence
from modallab.estimation.estimators.h1 import h1
from modallab.estimation.partial_coherence import coherence_of_frfs
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.periodic_variance import VarianceFactors

SimulatedDeviations = tuple[FloatArray, ComplexArray, FloatArray]
"""Deviations of force, FRF and response from their expectations in simulated tests, (n_tests, ..) each."""


def _side_by_side(runs: RealOrComplex, n_in: int = 1) -> RealOrComplex:
    """Return the responses (n_run, n_freq, n_out) of all runs by FRF, (n_freq, n_run n_in n_out)."""
    by_force = runs if n_in == 1 else np.tile(runs, n_in)
    out: RealOrComplex = by_force.swapaxes(0, 1).reshape(runs.shape[1], -1)
    return out


def frfs_side_by_side(runs: RealOrComplex) -> RealOrComplex:
    """Return FRFs (n_run, n_freq, n_out) or (.., n_in) of all runs as (n_freq, n_run n_in n_out)."""
    by_force = runs if runs.ndim == 3 else runs.swapaxes(2, 3)
    out: RealOrComplex = by_force.swapaxes(0, 1).reshape(runs.shape[1], -1)
    return out


def _forces(runs: FloatArray) -> FloatArray:
    """Return forces (n_run, n_freq) or (n_run, n_freq, n_in) of all runs side by side, (n_freq, n_force)."""
    return runs.T if runs.ndim == 2 else runs.swapaxes(0, 1).reshape(runs.shape[1], -1)


@dataclass(frozen=True, eq=False)
class VarianceRatios:
    """Variances of estimates over those of averages of independent Gaussian records, by line and channel."""

    force: FloatArray
    """(n_freq, n_force) of ln G_ff."""
    frf: FloatArray
    """(n_freq, n_out) of H1."""
    response: FloatArray
    """(n_freq, n_out) of the logarithm of the incoherent response spectrum."""
    deviations: SimulatedDeviations | None = None
    """Deviations of the three in simulated tests, see `VarianceFactors`; None if none were simulated."""

    @classmethod
    def of(cls, runs: VarianceFactors | None, spectra: CrossSpectra) -> "VarianceRatios":
        """Return the ratios of all runs side by side; 1 where all records are independent."""
        if runs is None:
            n_in = spectra.ff.shape[2]
            unit = _side_by_side(np.ones(spectra.xx.shape), n_in)
            return cls(np.ones((len(unit), n_in * len(spectra.ff))), unit, unit)
        deviations, n_in = None, spectra.ff.shape[2]
        if runs.tests is not None:
            force, frf, response = runs.tests
            h = np.array([frfs_side_by_side(test) for test in frf])
            incoherent = np.array([_side_by_side(test, n_in) for test in response])
            deviations = (np.array([_forces(test) for test in force]), h, incoherent)
        return cls(
            _forces(runs.force), frfs_side_by_side(runs.frf), _side_by_side(runs.response, n_in), deviations
        )

    def at(self, lines: IntArray) -> "VarianceRatios":
        """Return the ratios at some of the lines, (n,) indices; itself if these are all."""
        if len(lines) == len(self.frf):
            return self
        deviations = self.deviations
        if deviations is not None:
            force, frf, response = deviations
            deviations = force[:, lines], frf[:, lines], response[:, lines]
        return VarianceRatios(self.force[lines], self.frf[lines], self.response[lines], deviations)


@dataclass(frozen=True, eq=False)
class Predicted:
    """Expected spectra by FRF channel, as `Observed` holds the measured ones."""

    h: ComplexArray
    """(n_freq, n_out) H1 as inertance, 1/kg."""
    coherence: FloatArray
    """(n_freq, n_out), of several simultaneous forces the partial coherence."""
    force: FloatArray
    """(n_freq, n_force), N^2/Hz."""
    incoherent: FloatArray
    """(n_freq, n_out) G_xx (1 - coherence), (m/s^2)^2/Hz, floored at rounding."""
    excess_variance: Callable[[], FloatArray] | None = None
    """Variance ratio (n_freq, n_out) of the incoherent spectrum where power leaks.

    Computed on demand, as it costs more than the prediction itself.
    """
    variance_ratios: Callable[[], VarianceRatios] | None = None
    """Variance ratios where signals repeat in every average or come in bursts; computed on demand."""
    lines_correlated: bool = False
    """Whether lines share random numbers beyond those that a window mixes."""

    @classmethod
    def of(
        cls,
        spectra: CrossSpectra,
        excess_variance: Callable[[], FloatArray] | None = None,
        variance_factors: Callable[[], VarianceFactors | None] | None = None,
        *,
        lines_correlated: bool = False,
    ) -> "Predicted":
        """Return the channels of all runs side by side.

        Parameters
        ----------
        spectra
            Expected cross spectra of every run.
        excess_variance
            Variance ratio of the incoherent spectra, (n_run, n_freq, n_out).
        variance_factors
            Variance factors of every run.
        lines_correlated
            Whether lines share random numbers beyond those that a window mixes.
        """
        g2, h, n_in = coherence(spectra), h1(spectra), spectra.ff.shape[2]
        incoherent = spectra.xx * (1 - g2 + COHERENCE_ROUNDING)
        force = spectra.ff[..., np.arange(n_in), np.arange(n_in)].real
        return cls(
            frfs_side_by_side(h),
            frfs_side_by_side(coherence_of_frfs(spectra, h, g2)),
            _forces(force),
            _side_by_side(incoherent, n_in),
            None if excess_variance is None else lambda: _side_by_side(excess_variance(), n_in),
            None if variance_factors is None else lambda: VarianceRatios.of(variance_factors(), spectra),
            lines_correlated,
        )

    def at(self, lines: IntArray) -> "Predicted":
        """Return the spectra at some of the lines, (n,) indices; itself if these are all."""
        if len(lines) == len(self.h):
            return self
        excess, ratios = self.excess_variance, self.variance_ratios
        return Predicted(
            self.h[lines],
            self.coherence[lines],
            self.force[lines],
            self.incoherent[lines],
            None if excess is None else lambda: excess()[lines],
            None if ratios is None else lambda: ratios().at(lines),
            self.lines_correlated,
        )

    def times_ratio(self, near: "Predicted", reference: "Predicted") -> "Predicted":
        """Return the spectra times the ratio of approximate ones nearby to approximate ones of these."""
        return Predicted(
            near.h * (self.h / reference.h),
            near.coherence,
            near.force * (self.force / reference.force),
            near.incoherent * (self.incoherent / reference.incoherent),
        )
