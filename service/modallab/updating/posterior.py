"""A sample of what data and prior say of coefficients together."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, frozen
from modallab.updating.parameterisation import MacroElement
from modallab.updating.settings import ENSEMBLE


@dataclass(frozen=True, eq=False)
class PosteriorSample:
    """Draws of the coefficients that the prior leaves free, and how far they depend on one another."""

    macros: tuple[MacroElement, ...]  # (n_free,)
    draws: FloatArray  # (n_draws, n_free) coefficients
    log_density: FloatArray  # (n_draws,) of the posterior of their changes, up to a constant
    acceptance: float  # share of steps that were taken
    autocorrelation_time: (
        FloatArray  # (n_free,) draws of a chain that count as one, integrated autocorrelation
    )
    n_chains: int

    def __post_init__(self) -> None:
        n = len(self.macros)
        object.__setattr__(self, "draws", frozen(self.draws, float, (None, n), name="draws"))
        for name, shape in (("log_density", (len(self.draws),)), ("autocorrelation_time", (n,))):
            object.__setattr__(self, name, frozen(getattr(self, name), float, shape, name=name))

    @property
    def effective(self) -> FloatArray:
        """(n_free,) how many independent draws these are worth."""
        return np.asarray(len(self.draws) / np.maximum(self.autocorrelation_time, 1.0))

    @property
    def intervals(self) -> FloatArray:
        """(n_free, 2) between which 95 % of the draws lie."""
        return np.asarray(
            np.quantile(self.draws, (ENSEMBLE.interval_tail, 1 - ENSEMBLE.interval_tail), axis=0).T
        )
