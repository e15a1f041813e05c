"""The interface of predictions that fits and searches use, for one test or several."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol, Self

from numpy.typing import NDArray

from modallab.core.arrays import FloatArray
from modallab.diagnosis.optimisation.nuisances import Nuisances
from modallab.diagnosis.predicting.prediction_budget import PredictionBudget
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted, VarianceRatios
from modallab.diagnosis.residuals.residual import Residual
from modallab.fe.system import DynamicSystem
from modallab.rig.effect import Effect
from modallab.rig.setup import RigSetup

if TYPE_CHECKING:
    from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
    from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor


class Predictor(Protocol):
    """Expected spectra of one test or several, and the measurement they are compared with.

    Immutable: methods that change its state return another predictor. The nuisance parameters act in every
    prediction with the values of `position`.
    """

    @property
    def setup(self) -> RigSetup:
        """Log book of the first test."""

    @property
    def observed(self) -> Observed:
        """Measured spectra, of all tests one below the other."""

    @property
    def system(self) -> DynamicSystem:
        """The model without transducers and without deviations."""

    @property
    def step(self) -> int:
        """Lines from one line of a coarse prediction to the next, in the first test."""

    @property
    def nuisances(self) -> Nuisances:
        """Nuisance parameters."""

    @property
    def position(self) -> FloatArray:
        """(n,) of the nuisance parameters, standard deviations."""

    @property
    def budget(self) -> PredictionBudget:
        """Count of predictions, shared by all predictors of a diagnosis."""

    @property
    def tests(self) -> "tuple[SingleTestPredictor, ...]":
        """The predictors of the single tests."""

    def with_nuisances(self, nuisances: Nuisances) -> Self:
        """Return the predictor with nuisance parameters, all at the declared value."""

    def with_nuisances_at(self, position: FloatArray) -> Self:
        """Return the predictor with the nuisance parameters at a position (n,) in standard deviations."""

    def folded_into_matrices(self, effects: Sequence[Effect]) -> Self:
        """Return the predictor with effects in the structure's matrices, where many cost no more than one.

        Only effects equal in every run: members, springs, masses that stay.
        """

    def with_intermittent_errors(self, effects: Sequence[Effect]) -> Self:
        """Return the predictor with random errors as large as distortion in bursts makes them."""

    def without_lines(self, stride: int) -> Self:
        """Return the predictor with one of `stride` lines of each test held out as well."""

    def predict(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra with additional effects."""

    def residual(self, effects: Sequence[Effect]) -> Residual:
        """Return the whitened residual of the prediction at every line."""

    def coarse(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra at every `step`-th line, leakage on a coarse grid."""

    def coarse_prediction(self, effects: Sequence[Effect]) -> "CoarsePrediction":
        """Return coarse predictions of additions to some effects."""

    def linearisation_at(
        self, effects: Sequence[Effect], *, same_distortion: bool = False
    ) -> Callable[[Sequence[Effect]], Predicted]:
        """Return predictions near some effects for derivatives: leakage on one thin grid for all.

        Parameters
        ----------
        same_distortion
            Whether nonlinear forces under a continuous spectrum keep their equivalent linearisation and the
            spectra of what it leaves: ten times faster, for changes that hardly alter the motion.
        """

    def simulate_variance(self, effects: Sequence[Effect]) -> VarianceRatios | None:
        """Return variance ratios of simulated tests with distortion in bursts; None without bursts."""

    def stack_channels(self, parts: Sequence[NDArray[Any]], absent: complex) -> NDArray[Any]:
        """Return the arrays (.., n_freq, n_out) of all tests one below the other.

        Parameters
        ----------
        parts
            One array for each test.
        absent
            Value where a test has no such output.
        """
