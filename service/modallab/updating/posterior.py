"""Samples of a posterior distribution of coefficients."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, frozen
from modallab.updating.parameterisation import MacroElement, Part
from modallab.updating.settings import ENSEMBLE


@dataclass(frozen=True)
class SampledCoefficient:
    """Marginal posterior distribution of a coefficient, by its draws."""

    part: Part
    """Corrected part."""
    members: tuple[int, ...]
    """Members, or nodes, that share the coefficient."""
    mean: float
    """Mean of the draws."""
    standard_deviation: float
    """Standard deviation of the draws."""
    interval: tuple[float, float]
    """Lower and upper end of the central 95 % of the draws."""
    autocorrelation_time: float
    """draws, integrated autocorrelation time."""
    effective: float
    """Effective sample size: draws over autocorrelation time."""


@dataclass(frozen=True, eq=False)
class PosteriorSample:
    """Draws from the posterior of the free coefficients, with their autocorrelation."""

    macros: tuple[MacroElement, ...]
    """(n_free,) macro element of each free coefficient."""
    draws: FloatArray
    """Coefficients (n_draws, n_free)."""
    log_density: FloatArray
    """Log posterior density of the log changes (n_draws,), up to a constant."""
    acceptance: float
    """Accepted over proposed moves."""
    autocorrelation_time: FloatArray
    """draws, integrated autocorrelation time of each coefficient (n_free,)."""
    n_chains: int
    """chains, chains of the ensemble."""

    def __post_init__(self) -> None:
        n = len(self.macros)
        object.__setattr__(self, "draws", frozen(self.draws, float, (None, n), name="draws"))
        for name, shape in (("log_density", (len(self.draws),)), ("autocorrelation_time", (n,))):
            object.__setattr__(self, name, frozen(getattr(self, name), float, shape, name=name))

    @property
    def n_draws(self) -> int:
        """Number of draws."""
        return len(self.draws)

    @property
    def coefficients(self) -> tuple[SampledCoefficient, ...]:
        """Marginal posterior distribution of each free coefficient."""
        columns = zip(
            self.macros,
            self.draws.mean(axis=0).tolist(),
            self.draws.std(axis=0, ddof=1).tolist(),
            self.intervals.tolist(),
            self.autocorrelation_time.tolist(),
            self.effective.tolist(),
            strict=True,
        )
        return tuple(
            SampledCoefficient(macro.part, macro.members, mean, deviation, (low, high), time, size)
            for macro, mean, deviation, (low, high), time, size in columns
        )

    @property
    def effective(self) -> FloatArray:
        """(n_free,) effective sample size: draws over autocorrelation time."""
        return np.asarray(len(self.draws) / np.maximum(self.autocorrelation_time, 1.0))

    @property
    def intervals(self) -> FloatArray:
        """(n_free, 2) lower and upper end of the central 95 % of the draws."""
        return np.asarray(
            np.quantile(self.draws, (ENSEMBLE.interval_tail, 1 - ENSEMBLE.interval_tail), axis=0).T
        )
