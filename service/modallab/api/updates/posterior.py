"""Wire types of a posterior's draws."""

from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from modallab.updating.posterior import PosteriorSample


class DrawnOut(BaseModel):
    """A coefficient by its draws: 95 % lie in `interval`; they are worth `effective` independent ones."""

    part: str
    members: list[int]
    mean: float
    standard_deviation: float
    interval: tuple[float, float]
    effective: float


class PosteriorOut(BaseModel):
    """What data and prior say of coefficients together, without a straight line between."""

    n_draws: int
    n_chains: int
    acceptance: float
    coefficients: list[DrawnOut]

    @classmethod
    def of(cls, found: PosteriorSample) -> Self:
        """Return what the contract shows of a sample."""
        columns = zip(
            found.macros,
            found.draws.mean(axis=0).tolist(),
            found.draws.std(axis=0, ddof=1).tolist(),
            found.intervals.tolist(),
            found.effective.tolist(),
            strict=True,
        )
        coefficients = [
            DrawnOut(
                part=macro.part,
                members=list(macro.members),
                mean=mean,
                standard_deviation=deviation,
                interval=(low, high),
                effective=effective,
            )
            for macro, mean, deviation, (low, high), effective in columns
        ]
        return cls(
            n_draws=len(found.draws),
            n_chains=found.n_chains,
            acceptance=found.acceptance,
            coefficients=coefficients,
        )


def posterior_arrays(found: PosteriorSample) -> Mapping[str, NDArray[Any]]:
    """Return the draws and what they are of, under the names that the API serves."""
    return {
        "coefficients": np.array([str(macro) for macro in found.macros]),
        "draws": found.draws,
        "log_density": found.log_density,
    }
