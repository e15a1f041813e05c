"""Predictions of one test from model, log book and effects."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import FloatArray, IntArray
from modallab.diagnosis.optimisation.nuisances import Nuisances
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction, coarse_prediction
from modallab.diagnosis.predicting.coarse_spectra import CoarseSpectra
from modallab.diagnosis.predicting.decayed_prediction import decayed_predictions
from modallab.diagnosis.predicting.model_state import DeviatingModel
from modallab.diagnosis.predicting.prediction_budget import PredictionBudget, no_heartbeat
from modallab.diagnosis.predicting.settings import PREDICTION
from modallab.diagnosis.predicting.simulated_errors import simulated_factors, simulated_variance_ratios
from modallab.diagnosis.residuals.channel_noise import ChannelNoise
from modallab.diagnosis.residuals.free_levels import at_level_of
from modallab.diagnosis.residuals.levels_in_use import (
    with_expected_force_noise,
    with_levels_declared,
    with_measured_level,
)
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted, VarianceRatios
from modallab.diagnosis.residuals.residual import Residual, residual
from modallab.diagnosis.residuals.settings import FREE_LEVELS
from modallab.fe.modes import ModalBasis
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.rig.chain import Chain, chain
from modallab.rig.distortion import ResidualSpectra, residual_spectra
from modallab.rig.effect import Effect
from modallab.rig.effects_in_other_test import effects_in_other_test
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.expected import derivative_kernel, expected_spectra
from modallab.rig.free_decay import has_decayed
from modallab.rig.leakage_kernel import LeakageKernel
from modallab.rig.periodic_variance import periodic_factors
from modallab.rig.record_correlation import correlated_excess_variance
from modallab.rig.run import Run
from modallab.rig.setup import RigSetup
from modallab.rig.simulated_variance import SimulatedVariance, is_intermittent


@dataclass(frozen=True, eq=False)
class SingleTestPredictor:
    """Predicts one test exactly as its log book says, with additional effects; see `Predictor`."""

    model: DeviatingModel
    """The model with the nuisance parameters at their position."""
    setup: RigSetup
    """Log book."""
    observed: Observed
    """Measured spectra."""
    heartbeat: Callable[[], None] = no_heartbeat
    """Called before every prediction."""
    budget: PredictionBudget = field(default_factory=PredictionBudget)
    """Count of predictions, shared by all predictors of a diagnosis."""
    simulated: SimulatedVariance = field(default_factory=SimulatedVariance)
    """Variance factors of simulated tests, shared by all predictors of this test."""
    first_setup: RigSetup | None = None
    """Log book of the first test, whose places effects are named by; None if this is the first."""
    planned: bool = False
    """Whether the test is yet to be made: `observed` is then that of another test."""

    @classmethod
    def of(
        cls,
        structure: Structure,
        setup: RigSetup,
        observed: Observed,
        *,
        heartbeat: Callable[[], None] = no_heartbeat,
        budget: PredictionBudget | None = None,
    ) -> "SingleTestPredictor":
        """Return the predictor of a first test."""
        model, setup = DeviatingModel.of(structure), with_measured_level(setup, observed)
        predictor = cls(model, setup, observed, heartbeat, budget or PredictionBudget())
        return predictor._with_expected_force_noise()

    def follow_up(self, setup: RigSetup, observed: Observed) -> "SingleTestPredictor":
        """Return the predictor of a further test, with the same model and effects named as in this one."""
        own, first = with_measured_level(setup, observed), self.setup
        predictor = SingleTestPredictor(
            self.model, own, observed, self.heartbeat, self.budget, first_setup=first
        )
        return predictor._with_expected_force_noise()

    def _with_expected_force_noise(self) -> "SingleTestPredictor":
        def log_book_alone() -> Chain:
            return chain(self.model.deviating_system, self.setup, self.acting(()))

        return replace(self, observed=with_expected_force_noise(self.observed, log_book_alone, self.lines))

    def plan(self, setup: RigSetup) -> "SingleTestPredictor":
        """Return the predictor of a further test that is yet to be made, at all lines of its analyser."""
        declared = with_levels_declared(setup, self.observed, lambda: self.chain(()), self.lines)
        return replace(self.follow_up(*declared), planned=True)

    @property
    def system(self) -> DynamicSystem:
        """The model without transducers and without deviations."""
        return self.model.system

    @property
    def nuisances(self) -> Nuisances:
        """Nuisance parameters."""
        return self.model.nuisances

    @property
    def position(self) -> FloatArray:
        """(n,) of the nuisance parameters, standard deviations."""
        return self.model.position

    @cached_property
    def lines(self) -> IntArray:
        """(n_freq,) indices of the lines that are predicted, from 0 Hz on."""
        freq = self.setup.analyser.freq if self.planned else self.observed.freq
        return self.setup.baseband.analyser.lines_at(freq)

    @cached_property
    def step(self) -> int:
        """Lines from one line of a coarse prediction to the next."""
        step = max(1, len(self.lines) // PREDICTION.coarse_lines)
        # Of lines here and there, fewer than one in `step` may be a multiple of it.
        return step if 2 * step * (self.lines % step == 0).sum() >= len(self.lines) else 1

    @cached_property
    def coarse_places(self) -> IntArray:
        """(n,) indices of the lines of a coarse prediction among `lines`."""
        return np.flatnonzero(self.lines % self.step == 0)

    @cached_property
    def coarse_lines(self) -> IntArray:
        """(n,) indices of the same lines from 0 Hz on."""
        return self.lines[self.coarse_places]

    @property
    def level_known(self) -> bool:
        """Whether log book or force spectrum tell the level of the source."""
        return self.observed.level_known

    @property
    def tests(self) -> "tuple[SingleTestPredictor, ...]":
        """The predictor itself."""
        return (self,)

    def with_nuisances(self, nuisances: Nuisances) -> "SingleTestPredictor":
        """Return the predictor with nuisance parameters, all at the declared value."""
        predictor = replace(self, model=replace(self.model, nuisances=nuisances))
        return predictor.with_nuisances_at(np.zeros(len(nuisances)))

    def with_nuisances_at(self, position: FloatArray) -> "SingleTestPredictor":
        """Return the predictor with the nuisance parameters at a position (n,) in standard deviations."""
        return replace(self, model=self.model.at_position(position, self.setup.acquisition_runs[0]))

    def folded_into_matrices(self, effects: Sequence[Effect]) -> "SingleTestPredictor":
        """Return the predictor with effects in the structure's matrices, see `Predictor`."""
        return replace(self, model=self.model.folded(effects, self.setup.acquisition_runs[0]))

    def with_intermittent_errors(self, effects: Sequence[Effect]) -> "SingleTestPredictor":
        """Return the predictor with random errors as large as distortion in bursts makes them."""
        if not is_intermittent(effects, self.setup):
            return self
        ratios = self.predict(effects).variance_ratios
        assert ratios is not None
        return replace(self, observed=self.observed.with_variance_ratios(ratios()))

    def without_lines(self, stride: int) -> "SingleTestPredictor":
        """Return the predictor with one of `stride` lines held out as well.

        At steps of the golden section: at even steps harmonics would all be held out, or none of them.
        """
        golden_section = (5**0.5 - 1) / 2
        lines = np.arange(len(self.observed.freq)) * golden_section % 1 < 1 / stride
        held_out_lines = self.observed.held_out_lines | lines
        return replace(self, observed=replace(self.observed, held_out_lines=held_out_lines))

    def chain(
        self,
        effects: Sequence[Effect],
        *,
        same_in_all_runs: bool = False,
        initial_rms: FloatArray | None = None,
        linearised: Sequence[Run] | None = None,
        share: float = 1.0,
        runs: Sequence[int] | None = None,
    ) -> Chain:
        """Return the measuring chain of the model on the rig of the log book, with additional effects.

        Parameters
        ----------
        same_in_all_runs
            Whether nonlinear forces see the same motion in every run, for coarse predictions.
        initial_rms
            Motion of the nonlinear forces (n_run, r) in an almost equal chain, if it is known.
        linearised
            Runs of an almost equal chain, whose equivalent linearisation is taken as it is.
        share
            Share of the lines that are predicted.
        runs
            Indices of the runs that are predicted; None: all.
        """
        self.heartbeat()
        measuring_chain = chain(
            self.model.deviating_system,
            self.setup,
            self.acting(self._in_this_test(effects)),
            same_in_all_runs=same_in_all_runs,
            initial_rms=initial_rms,
            linearised=linearised,
            only=runs,
        )
        solved = linearised is None and len(measuring_chain.runs[0].local_forces) > 0
        nonlinear = solved and measuring_chain.source.continuous > 0
        share *= len(measuring_chain.runs) / len(self.setup.acquisition_runs)
        self.budget.spend(share * PREDICTION.nonlinear_cost if nonlinear else share)
        return measuring_chain

    def _in_this_test(self, effects: Sequence[Effect]) -> Sequence[Effect]:
        return (
            effects
            if self.first_setup is None
            else effects_in_other_test(effects, self.first_setup, self.setup)
        )

    def acting(self, effects: Sequence[Effect]) -> list[Effect]:
        """Return the effects of the model and the deviations of its runs, then some effects."""
        return [*self.model.model_effects, *self.model.run_deviations, *effects]

    def predict(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra with additional effects."""
        measuring_chain = self.chain(effects)
        leaking = measuring_chain.source.continuous > 0
        excitation, factors = EXCITATIONS[self.setup.analyser.excitation.kind], None
        intermittent = is_intermittent(effects, self.setup)
        if not (leaking or excitation.deterministic or intermittent or excitation.transient):
            return self._expected(measuring_chain)
        spectra = self.observed.with_levels(expected := expected_spectra(measuring_chain), self.lines)
        if excitation.deterministic:
            factors = partial(periodic_factors, measuring_chain, at_level_of(expected, spectra))
        elif intermittent:
            factors = partial(simulated_factors, self, measuring_chain, expected, effects)
        return Predicted.of(
            spectra,
            partial(correlated_excess_variance, measuring_chain, spectra) if leaking else None,
            factors,
            lines_correlated=leaking or intermittent or excitation.transient is not None,
        ).at(self.lines)

    def _expected(
        self,
        measuring_chain: Chain,
        kernel: LeakageKernel | None = None,
        noise: ChannelNoise | None = None,
        distortion: ResidualSpectra | None = None,
    ) -> Predicted:
        """Return the expected spectra of a chain, without variances.

        Parameters
        ----------
        noise, distortion
            Of a chain very much like it: from the one the fit of free levels starts, the other is kept.
        """
        spectra = expected_spectra(measuring_chain, kernel, self.lines, distortion)
        last_step = FREE_LEVELS.last_step if noise is None else FREE_LEVELS.near_step
        return Predicted.of(self.observed.with_levels(spectra, start=noise, last_step=last_step))

    def residual(self, effects: Sequence[Effect]) -> Residual:
        """Return the whitened residual of the prediction at every line."""
        return residual(self.observed, self.predict(effects))

    def simulate_variance(self, effects: Sequence[Effect]) -> VarianceRatios | None:
        """Return variance ratios of simulated tests with distortion in bursts; None without bursts."""
        return simulated_variance_ratios(self, effects)

    def linearisation_at(
        self, effects: Sequence[Effect], *, same_distortion: bool = False
    ) -> Callable[[Sequence[Effect]], Predicted]:
        """Return predictions near some effects for derivatives, see `Predictor`."""
        if has_decayed(base := self.chain(effects), PREDICTION.remaining_decay):
            return decayed_predictions(self, effects, self._expected(base))
        kernel, motion = derivative_kernel(base), base.local_rms
        distortion = linearised = None
        if same_distortion and kernel is not None and base.runs[0].local_forces:
            linearised = base.runs
            distortion = residual_spectra(linearised, base.setup.analyser, base.source, kernel.nodes)
        noise = self.observed.channel_noise(expected_spectra(base, kernel, self.lines, distortion))

        def predict(perturbed: Sequence[Effect]) -> Predicted:
            near = self.chain(perturbed, initial_rms=motion, linearised=linearised)
            return self._expected(near, kernel, noise, distortion)

        return predict

    def with_frequency_shift(self, effects: Sequence[Effect], shift: float) -> Predicted:
        """Return the expected spectra with every natural frequency shifted by a ratio of itself."""
        system = self.model.deviating_system.scaled(stiffness=(1 + shift) ** 2)
        return self._expected(chain(system, self.setup, self.acting(self._in_this_test(effects))))

    @cached_property
    def coarse_spectra(self) -> CoarseSpectra:
        """Expected spectra at every `step`-th line."""
        return CoarseSpectra(self, self.observed if self.planned else self.observed.at(self.coarse_places))

    def coarse(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra at every `step`-th line, leakage on a coarse grid."""
        return self.coarse_spectra.predict(effects)

    def coarse_prediction(self, effects: Sequence[Effect]) -> CoarsePrediction:
        """Return coarse predictions of additions to some effects."""
        return coarse_prediction(self, effects)

    def stack_channels(self, parts: Sequence[NDArray[Any]], absent: complex) -> NDArray[Any]:
        """Return the array of the one test, see `Predictor`."""
        return parts[0]

    def modes(self) -> ModalBasis:
        """Return the elastic modes of the model with the transducers of the first run, in the band."""
        system = chain(self.model.system, self.setup, self.model.model_effects).runs[0].system
        frequency_max = self.setup.analyser.frequency_max
        basis = system.modes(frequency_max).elastic()
        return basis.elastic(max(1, int((basis.frequencies <= frequency_max).sum())))
