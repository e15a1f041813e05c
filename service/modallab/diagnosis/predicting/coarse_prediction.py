"""Coarse predictions of additions to some effects: fewer lines, leakage on a coarse grid."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.diagnosis.optimisation.fit_parameters import ParameterVector
from modallab.diagnosis.optimisation.linear_nuisances import LinearNuisances, NuisanceProjection
from modallab.diagnosis.optimisation.settings import NUISANCE
from modallab.diagnosis.predicting.coarse_spectra import CoarseBase, CoarseSpectra
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.residual import inflation_weights, residual
from modallab.rig.effect import Effect, is_nonlinear

if TYPE_CHECKING:
    from modallab.diagnosis.predicting.predictor import Predictor
    from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor


@dataclass(frozen=True, eq=False)
class CoarsePrediction:
    """Coarse predictions of additions to some base effects, with what they are compared with."""

    predictor: "Predictor"
    """The predictor that the coarse predictions approximate."""
    base: Sequence[Effect]
    """Effects without the addition."""
    observed: Observed
    """Measured spectra at the coarse lines."""
    predict: Callable[[Sequence[Effect]], Predicted]
    """Return the expected spectra at the coarse lines with all these effects."""
    known_derivatives: FloatArray | None = None
    """Derivatives of `nuisances` of a prediction much like this one; None: they are computed."""
    predict_together: Callable[[Sequence[Effect]], list[Predicted]] | None = None
    """Return what `predict_each` does at less cost; None: there is no such way."""

    def predict_each(self, additions: Sequence[Effect]) -> list[Predicted]:
        """Return the expected spectra of the base effects with each of some additions, one at a time."""
        if self.predict_together is not None:
            return self.predict_together(additions)
        return [self.predict([*self.base, addition]) for addition in additions]

    def subsampled(self, stride: int) -> "CoarsePrediction":
        """Return the prediction compared at one of `stride` lines per channel, shifted between channels."""
        if stride < 2:
            return self
        line, channel = np.indices(self.observed.usable.shape)
        usable = self.observed.usable & ((line + channel) % stride == 0)
        return replace(self, observed=replace(self.observed, usable=usable))

    def _vector(self, predicted: Predicted) -> FloatArray:
        return residual(self.observed, predicted).vector(self.observed.fitted)

    @cached_property
    def derivatives(self) -> FloatArray:
        """(n_residuals, n): derivatives of residuals by the nuisance parameters of tolerances."""
        nuisances = self.predictor.nuisances

        def predict(deviations: Sequence[Effect]) -> Predicted:
            return self.predict([*self.base, *deviations])

        if not len(nuisances):
            return np.zeros((0, 0))
        indices = np.arange(len(nuisances))
        position = self.predictor.position
        return nuisances.derivatives(predict, self._vector, predict(()), self.observed, position, indices)

    @cached_property
    def nuisances(self) -> LinearNuisances:
        """Nuisance parameters beside a candidate: those of the base effects, then those of tolerances."""
        parameters, position = ParameterVector(self.base), self.predictor.position
        n, prior = len(parameters), self.observed.correlation_length * np.ones(len(position))
        reach, limit = NUISANCE.parameter_range, self.predictor.nuisances.limits
        start = parameters.start
        low, high = np.clip([parameters.low - start, parameters.high - start], -reach, reach)
        known = self.known_derivatives
        return LinearNuisances(
            self._nuisance_derivatives(parameters) if known is None else known,
            np.concatenate([np.zeros(n), position]),
            np.concatenate([np.full(n, 1 / reach**2), prior]),
            np.concatenate([low, -limit]),
            np.concatenate([high, limit]),
        )

    def _nuisance_derivatives(self, parameters: ParameterVector) -> FloatArray:
        """Return the derivatives (n_residuals, n) by parameters of the base effects, then by tolerances."""
        blocks = [self.derivatives] if len(self.predictor.position) else []
        if len(parameters):
            base = self._vector(self.predict(self.base))
            perturbed = parameters.perturbed(parameters.start)
            columns = [(self._vector(self.predict(effects)) - base) / step for effects, step in perturbed]
            blocks.insert(0, np.array(columns).T)
        return np.hstack(blocks) if blocks else np.zeros((0, 0))

    def project_out(self, vectors: FloatArray, noise_inflation: float) -> FloatArray:
        """Return weighted residuals less the part that nuisance parameters explain.

        Parameters
        ----------
        vectors
            (..., n_residuals), weighted by `inflation_weights` of the noise inflation.
        noise_inflation
            Relative error added to every random error.
        """
        if noise_inflation not in self._projections:
            weights = inflation_weights(self.observed, self.observed.fitted, noise_inflation)
            self._projections[noise_inflation] = self.nuisances.weighted(weights)
        return self._projections[noise_inflation](vectors)

    @cached_property
    def _projections(self) -> dict[float, NuisanceProjection]:
        return {}


@dataclass(frozen=True, eq=False)
class _CorrectedSpectra:
    """Coarse spectra of one test, times the ratio of exact to coarse ones without the addition.

    The error of leakage on a coarse grid, of means over few lines, and of distortion left out is nearly the
    same with and without a small addition, and so cancels in the ratio.
    """

    spectra: CoarseSpectra
    base: CoarseBase
    exact: Predicted
    """Exact prediction without an addition, at every `step`-th line."""

    def predict(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra at every `step`-th line with all these effects."""
        coarse = self.spectra.predict(effects, self.base)
        return self.exact.times_ratio(coarse, self._reference(effects))

    def predict_each(self, additions: Sequence[Effect]) -> list[Predicted]:
        """Return the expected spectra at every `step`-th line with each of some additions."""
        base = self.base.effects
        if is_nonlinear(additions):
            return [self.predict([*base, addition]) for addition in additions]
        each = self.spectra.predict_each(additions, self.base)
        return [
            self.exact.times_ratio(coarse, self._reference([*base, addition]))
            for coarse, addition in zip(each, additions, strict=True)
        ]

    def _reference(self, effects: Sequence[Effect]) -> Predicted:
        """Return the coarse prediction of the base alone, as coarse in every way as that of the effects."""
        distortion = not self.base.keeps_linearisation(effects)
        all_lines = self.spectra.is_narrow_in_force(effects, self.base)
        if (distortion, all_lines) not in self._references:
            self._references[distortion, all_lines] = self.spectra.predict_base(
                self.base, distortion=distortion, noise_of_all_lines=all_lines
            )
        return self._references[distortion, all_lines]

    @cached_property
    def _references(self) -> dict[tuple[bool, bool], Predicted]:
        return {}


def coarse_prediction(predictor: "SingleTestPredictor", base: Sequence[Effect]) -> CoarsePrediction:
    """Return coarse predictions of additions to base effects, exact without an addition."""
    lines = predictor.coarse_places
    coarse = predictor.coarse_spectra
    spectra = _CorrectedSpectra(coarse, coarse.base(base), predictor.predict(base).at(lines))
    return CoarsePrediction(
        predictor,
        base,
        predictor.observed.at(lines),
        spectra.predict,
        predict_together=spectra.predict_each,
    )
