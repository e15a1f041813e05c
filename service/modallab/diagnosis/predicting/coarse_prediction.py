"""First looks at what is added to some effects: fewer lines, leakage on a coarse grid."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.optimisation.fit_parameters import ParameterVector
from modallab.diagnosis.optimisation.linear_nuisances import LinearNuisances, NuisanceProjection
from modallab.diagnosis.optimisation.settings import NUISANCE
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.residual import inflation_weights, residual
from modallab.rig.effect import Effect

if TYPE_CHECKING:
    from modallab.diagnosis.predicting.predictor import Predictor


class CoarsePrediction:
    """First looks: coarse predictions, set right by what is exact without the addition.

    What a coarse grid gets wrong about leakage is nearly the same with and without a small
    addition, and so cancels in their ratio.
    """

    def __init__(self, predictor: "Predictor", base: Sequence[Effect]) -> None:
        self.predictor, self.base = predictor, base
        self.observed = predictor.observed.decimated(predictor.step)
        exact, coarse = predictor.predict(base), predictor.coarse(base)
        every = slice(None, None, predictor.step)
        self._h = exact.h[every] / coarse.h
        self._force = exact.force[every] / coarse.force
        self._incoherent = exact.incoherent[every] / coarse.incoherent

    def predict(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra at every `step`-th line with all these effects."""
        coarse = self.predictor.coarse(effects)
        return Predicted(
            coarse.h * self._h,
            coarse.coherence,
            coarse.force * self._force,
            coarse.incoherent * self._incoherent,
        )

    def subsampled(self, every: int) -> "CoarsePrediction":
        """Return the same at one of so many lines in each channel, other lines in the next channel."""
        if every < 2:
            return self
        line, channel = np.indices(self.observed.usable.shape)
        other = copy(self)
        for name in ("derivatives", "nuisances", "_blurred"):
            other.__dict__.pop(name, None)
        usable = self.observed.usable & ((line + channel) % every == 0)
        other.observed = replace(self.observed, usable=usable)
        return other

    @cached_property
    def derivatives(self) -> FloatArray:
        """(n_residuals, n): how residuals change with what is tolerated, by standard deviations of it."""
        observed, numbers = self.observed, self.predictor.nuisances

        def near(more: Sequence[Effect]) -> Predicted:
            return self.predict([*more, *self.base])

        def vector(predicted: Predicted) -> FloatArray:
            return residual(observed, predicted).vector(observed.fitted)

        if not len(numbers):
            return np.zeros((0, 0))
        return numbers.derivatives(near, vector, near(()), observed, np.arange(len(numbers)))

    @cached_property
    def nuisances(self) -> LinearNuisances:
        """What moves along with a suspect: the numbers of the base, and what is tolerated."""
        observed, panel, also = self.observed, ParameterVector(self.base), self.predictor.position

        def vector(effects: Sequence[Effect]) -> FloatArray:
            return residual(observed, self.predict(effects)).vector(observed.fitted)

        n, prior = len(panel), observed.correlation_length * np.ones(len(also))
        blocks = [self.derivatives] if len(also) else []
        if n:
            here = vector(self.base)
            columns = [(vector(near) - here) / step for near, step in panel.perturbed(panel.start)]
            blocks.insert(0, np.array(columns).T)
        reach = NUISANCE.parameter_range
        near = np.clip([panel.low - panel.start, panel.high - panel.start], -reach, reach)
        return LinearNuisances(
            np.hstack(blocks) if blocks else np.zeros((0, 0)),
            np.concatenate([np.zeros(n), also]),
            np.concatenate([np.full(n, 1 / NUISANCE.parameter_range**2), prior]),
            np.concatenate([near[0], np.full(len(also), -NUISANCE.max_deviation)]),
            np.concatenate([near[1], np.full(len(also), NUISANCE.max_deviation)]),
        )

    def project_out(self, vectors: FloatArray, widening: float) -> FloatArray:
        """Return residuals (..., n_residuals), blurred so much, less what `nuisances` explains."""
        if widening not in self._blurred:
            weights = inflation_weights(self.observed, self.observed.fitted, widening)
            self._blurred[widening] = self.nuisances.weighted(weights)
        return self._blurred[widening](vectors)

    @cached_property
    def _blurred(self) -> dict[float, NuisanceProjection]:
        return {}
