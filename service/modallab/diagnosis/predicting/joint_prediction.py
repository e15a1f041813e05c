"""Predictions of several tests of one structure at once."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import FloatArray
from modallab.diagnosis.optimisation.nuisances import Nuisances
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.predicting.prediction_budget import PredictionBudget
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.predicting.stacking import SpectrumStack
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted, VarianceRatios
from modallab.diagnosis.residuals.residual import Residual, residual
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import Effect
from modallab.rig.setup import RigSetup


@dataclass(frozen=True, eq=False)
class JointPredictor:
    """Predicts several tests at once, their spectra stacked; see `Predictor`."""

    tests: tuple[SingleTestPredictor, ...]
    """The predictors of the single tests, the first one first."""
    stack: SpectrumStack
    """Places of the tests' spectra."""
    observed: Observed
    """Measured spectra of all tests."""

    @classmethod
    def of(cls, tests: Sequence[SingleTestPredictor]) -> "JointPredictor":
        """Return the predictor of several tests."""
        observed = [test.observed for test in tests]
        stack = SpectrumStack.of(observed, roving=tests[0].setup.accelerometers.roving)
        return cls(tuple(tests), stack, stack.observed(observed))

    @property
    def setup(self) -> RigSetup:
        """Log book of the first test."""
        return self.tests[0].setup

    @property
    def system(self) -> DynamicSystem:
        """The model without transducers and without deviations."""
        return self.tests[0].system

    @property
    def step(self) -> int:
        """Lines from one line of a coarse prediction to the next, in the first test."""
        return self.tests[0].step

    @property
    def nuisances(self) -> Nuisances:
        """Nuisance parameters."""
        return self.tests[0].nuisances

    @property
    def position(self) -> FloatArray:
        """(n,) of the nuisance parameters, standard deviations."""
        return self.tests[0].position

    @property
    def budget(self) -> PredictionBudget:
        """Count of predictions of all tests."""
        return self.tests[0].budget

    def with_nuisances(self, nuisances: Nuisances) -> "JointPredictor":
        """Return the predictor with nuisance parameters, all at the declared value."""
        return replace(self, tests=tuple(test.with_nuisances(nuisances) for test in self.tests))

    def with_nuisances_at(self, position: FloatArray) -> "JointPredictor":
        """Return the predictor with the nuisance parameters at a position (n,) in standard deviations."""
        return replace(self, tests=tuple(test.with_nuisances_at(position) for test in self.tests))

    def folded_into_matrices(self, effects: Sequence[Effect]) -> "JointPredictor":
        """Return the predictor with effects in the structure's matrices, see `Predictor`."""
        return replace(self, tests=tuple(test.folded_into_matrices(effects) for test in self.tests))

    def with_intermittent_errors(self, effects: Sequence[Effect]) -> "JointPredictor":
        """Return the predictor with random errors as large as distortion in bursts makes them."""
        return JointPredictor.of([test.with_intermittent_errors(effects) for test in self.tests])

    def without_lines(self, stride: int) -> "JointPredictor":
        """Return the predictor with one of `stride` lines of each test held out as well."""
        return JointPredictor.of([test.without_lines(stride) for test in self.tests])

    def predict(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra of all tests."""
        return self.stack.predicted([test.predict(effects) for test in self.tests])

    def residual(self, effects: Sequence[Effect]) -> Residual:
        """Return the whitened residual of the prediction at every line of all tests."""
        return residual(self.observed, self.predict(effects))

    def coarse(self, effects: Sequence[Effect]) -> Predicted:
        """Return the coarse spectra of all tests."""
        return self.stack.predicted([test.coarse(effects) for test in self.tests])

    def coarse_prediction(self, effects: Sequence[Effect]) -> CoarsePrediction:
        """Return coarse predictions of additions to some effects."""
        parts = [test.coarse_prediction(effects) for test in self.tests]

        def predict(additions: Sequence[Effect]) -> Predicted:
            return self.stack.predicted([part.predict(additions) for part in parts])

        def predict_each(additions: Sequence[Effect]) -> list[Predicted]:
            by_test = [part.predict_each(additions) for part in parts]
            return [self.stack.predicted(of_tests) for of_tests in zip(*by_test, strict=True)]

        observed = self.stack.observed([part.observed for part in parts])
        return CoarsePrediction(self, effects, observed, predict, predict_together=predict_each)

    def linearisation_at(
        self, effects: Sequence[Effect], *, same_distortion: bool = False
    ) -> Callable[[Sequence[Effect]], Predicted]:
        """Return predictions near some effects for derivatives, see `Predictor`."""
        parts = [test.linearisation_at(effects, same_distortion=same_distortion) for test in self.tests]
        return lambda perturbed: self.stack.predicted([predict(perturbed) for predict in parts])

    def simulate_variance(self, effects: Sequence[Effect]) -> VarianceRatios | None:
        """Return variance ratios of simulated tests; None if one test has no distortion in bursts."""
        simulated = [test.simulate_variance(effects) for test in self.tests]
        ratios = [part for part in simulated if part is not None]
        return self.stack.variance_ratios(ratios) if len(ratios) == len(self.tests) else None

    def stack_channels(self, parts: Sequence[NDArray[Any]], absent: complex) -> NDArray[Any]:
        """Return the arrays (.., n_freq, n_out) of all tests one below the other, see `Predictor`."""
        return np.asarray(self.stack.channels(parts, absent))
