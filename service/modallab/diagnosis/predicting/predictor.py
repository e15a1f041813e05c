"""What the log book and a list of effects predict for a measurement."""

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.diagnosis.optimisation.nuisances import Nuisances, split_by_scope
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.predicting.prediction_budget import PredictionBudget
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted, VarianceRatios
from modallab.diagnosis.residuals.residual import Residual, residual
from modallab.estimation.spectra import CrossSpectra
from modallab.fe.assembly import assemble
from modallab.fe.modes import ModalBasis
from modallab.fe.structure import Structure
from modallab.rig.chain import Chain, chain
from modallab.rig.channel import Channel
from modallab.rig.effect import Effect, build
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.expected import coarse_spectra, derivative_kernel, expected_spectra
from modallab.rig.measurement import Measurement
from modallab.rig.periodic_variance import VarianceFactors, periodic_factors
from modallab.rig.record_correlation import correlated_excess_variance
from modallab.rig.setup import RigSetup
from modallab.rig.simulated_variance import SimulatedVariance, is_intermittent
from modallab.rig.spectrum_settings import SIMULATED_VARIANCE

GOLDEN = (5**0.5 - 1) / 2
GLIMPSED = 130  # lines that a first look uses
STEPPED = 30  # predictions with a nonlinear force that take as long as stepping it through one test


class Predictor:
    """Predicts the measurement exactly as the log book says, with some effects more.

    What is tolerated stands where `position` has it and acts in every prediction.
    """

    nuisances = Nuisances()
    position: FloatArray = np.zeros(0)  # of what is tolerated, standard deviations
    tolerated: tuple[Effect, ...] = ()
    _rest: Sequence[Effect] = ()  # of these, what acts elsewhere than on the model as a whole

    def __init__(self, structure: Structure, setup: RigSetup, observed: Observed) -> None:
        self.setup, self.observed = setup, observed
        self.heartbeat: Callable[[], None] = _unheard  # called before every prediction
        self.budget = PredictionBudget()
        self.system = self._loose = assemble(structure)
        self._own = [build(spec) for spec in structure.effects]
        self.step = max(1, setup.analyser.n_lines // GLIMPSED)
        self._rehearsals = SimulatedVariance()

    @property
    def tests(self) -> tuple["Predictor", ...]:
        """The predictors of single tests that this one is made of."""
        return (self,)

    def chain(
        self,
        effects: Sequence[Effect],
        *,
        same_in_all_runs: bool = False,
        initial_rms: FloatArray | None = None,
    ) -> Chain:
        """Return the measuring chain of the model on the rig of the log book, with some effects more.

        Parameters
        ----------
        same_in_all_runs
            Whether nonlinear forces are taken to move alike in every run, for first looks.
        initial_rms
            What they take (n_run, r) in a chain that differs by next to nothing, if that is known.
        """
        self.heartbeat()
        self.budget.spend()
        return chain(
            self._loose,
            self.setup,
            self._with(effects),
            same_in_all_runs=same_in_all_runs,
            initial_rms=initial_rms,
        )

    def _with(self, effects: Sequence[Effect]) -> list[Effect]:
        return [*self._own, *self._rest, *effects]

    def with_nuisances(self, numbers: Nuisances) -> "Predictor":
        """Return the same with numbers that may differ a little, all as declared."""
        other = copy(self)
        other.nuisances = numbers
        return other.with_nuisances_at(np.zeros(len(numbers)))

    def with_nuisances_at(self, position: FloatArray) -> "Predictor":
        """Return the same with what may differ a little so many standard deviations (n,) off."""
        other = copy(self)
        other.position, other.tolerated = position, self.nuisances.effects(position)
        # What is alike in every run is done to the model once.
        whole, other._rest = split_by_scope(other.tolerated)
        other._loose = self.system
        for effect in whole:
            other._loose = effect.on_system(other._loose, self.setup.acquisition_runs[0])
        return other

    def folded_into_matrices(self, effects: Sequence[Effect]) -> "Predictor":
        """Return the same with effects put into the structure's matrices, where many cost no more than one.

        Only what is alike in every run: members, springs, masses that stay.
        """
        other = copy(self)
        for effect in effects:
            other._loose = effect.on_system(other._loose, self.setup.acquisition_runs[0])
        other._loose = other._loose.folded()
        return other

    def predict(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra."""
        whole = self.chain(effects)
        spectra = expected_spectra(whole)
        leaking = whole.source.continuous > 0
        excitation, steady = EXCITATIONS[self.setup.analyser.excitation.kind], None
        bursts = is_intermittent(effects, self.setup)
        if excitation.deterministic:
            steady = partial(periodic_factors, whole, spectra)
        elif bursts:
            steady = partial(self._rehearsed, whole, spectra, effects)
        return Predicted.of(
            spectra,
            partial(correlated_excess_variance, whole, spectra) if leaking else None,
            steady,
            lines_correlated=leaking or bursts or excitation.transient is not None,
        )

    def with_intermittent_errors(self, effects: Sequence[Effect]) -> "Predictor":
        """Return the same with random errors as large as distortion that comes in bursts makes them."""
        if not is_intermittent(effects, self.setup):
            return self
        predicted = self.predict(effects)
        assert predicted.variance_ratios is not None
        other = copy(self)
        other.observed = self.observed.with_variance_ratios(predicted.variance_ratios())
        return other

    def simulate_variance(self, effects: Sequence[Effect]) -> VarianceRatios | None:
        """Return what tests are like in which distortion comes in bursts, as many as errors ask for."""
        if not is_intermittent(effects, self.setup):
            return None
        whole = self.chain(effects)
        spectra = expected_spectra(whole)
        found = self._rehearsed(whole, spectra, effects, SIMULATED_VARIANCE.n_tests)
        return None if found is None else VarianceRatios.of(found, spectra)

    def _rehearsed(
        self, whole: Chain, spectra: CrossSpectra, effects: Sequence[Effect], repeats: int | None = None
    ) -> VarianceFactors | None:
        before = self._rehearsals.n_simulated
        found = self._rehearsals.factors(whole, spectra, effects, repeats=repeats)
        self.budget.spend(STEPPED * len(whole.runs[0].local_forces) * (self._rehearsals.n_simulated - before))
        return found

    def linearisation_at(self, effects: Sequence[Effect]) -> Callable[[Sequence[Effect]], Predicted]:
        """Return predictions to differentiate with, near some effects: leakage on one thin grid for all."""
        here = self.chain(effects)
        view, taken = derivative_kernel(here), here.local_rms

        def sketch(near: Sequence[Effect]) -> Predicted:
            return Predicted.of(expected_spectra(self.chain(near, initial_rms=taken), view))

        return sketch

    def residual(self, effects: Sequence[Effect]) -> Residual:
        """Return the whitened residual of the prediction at every line."""
        return residual(self.observed, self.predict(effects))

    def with_frequency_shift(self, effects: Sequence[Effect], shift: float) -> Predicted:
        """Return the expected spectra with every natural frequency moved by a small share of itself."""
        system = self._loose.scaled(stiffness=(1 + shift) ** 2)
        whole = chain(system, self.setup, self._with(effects))
        return Predicted.of(expected_spectra(whole))

    def coarse(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra at every `step`-th line, leakage coarse."""
        return Predicted.of(coarse_spectra(self.chain(effects, same_in_all_runs=True), self.step))

    def without_lines(self, every: int) -> "Predictor":
        """Return the same with one of so many lines held out of its fits as well.

        At steps of the golden section: at even steps harmonics would all be held out, or none of them.
        """
        lines = np.arange(len(self.observed.freq)) * GOLDEN % 1 < 1 / every
        other = copy(self)
        other.observed = replace(self.observed, held_out_lines=self.observed.held_out_lines | lines)
        return other

    def stack_channels(self, parts: Sequence[NDArray[Any]], absent: complex) -> NDArray[Any]:
        """Return what the tests have by line and output (.., n_freq, n_out), one below the other.

        Parameters
        ----------
        absent
            What stands where one of them has no such output.
        """
        (own,) = parts
        return own

    def coarse_prediction(self, effects: Sequence[Effect]) -> CoarsePrediction:
        """Return first looks at what is added to some effects."""
        return CoarsePrediction(self, effects)

    def modes(self) -> ModalBasis:
        """Return the elastic modes of the model with what the first run attaches to it."""
        first = chain(self.system, self.setup, self._own).runs[0].system
        top = self.setup.analyser.frequency_max
        basis = first.modes(top).elastic()
        return basis.elastic(max(1, int((basis.frequencies <= top).sum())))

    def unmeasured_inertance(self, effects: Sequence[Effect], dofs: tuple[Dof, ...]) -> ComplexArray:
        """Return the inertance (n_freq, n_dof, 1) at DoFs where nothing was measured.

        A roving accelerometer is thought to visit them; fixed ones stay where they are.
        """
        extended = self._with(effects)
        freq = self.observed.freq
        if self.setup.accelerometers.roving:
            visited = chain(self._loose, replace(self.setup, responses=dofs), extended)
            return np.asarray(visited.respond(freq).inertance[:, :, 0, 0].T[..., None])
        first = chain(self._loose, self.setup, extended).runs[0]
        acquisition_run = replace(first.acquisition_run, outputs=dofs)
        elsewhere = replace(first, acquisition_run=acquisition_run, responses=tuple(map(Channel.ideal, dofs)))
        whole = replace(chain(self._loose, self.setup), runs=(elsewhere,))
        return np.asarray(whole.respond(freq).inertance[0])


def _unheard() -> None:
    """Nobody waits to hear."""


def check_comparable(structure: Structure, measurement: Measurement) -> None:
    """Raise unless the model and the log book can predict the measurement.

    Raises
    ------
    InvalidInputError
        If the frequency axis is not the log book's, 0 Hz apart, or several forces act at once.
    UnknownDofError
        If the model lacks a measured DoF.
    """
    for dof in (measurement.setup.drive, *measurement.frf.outputs):
        structure.index(dof)
    if measurement.frf.values.shape[2] != 1:
        raise InvalidInputError("one force at a time", field="inputs", allowed="1")
    axis, freq = measurement.setup.analyser.freq, measurement.frf.freq
    if freq[0] > 0:
        axis = axis[1:]
    if len(axis) != len(freq) or not np.allclose(axis, freq, rtol=1e-6, atol=1e-6 * axis[-1]):
        raise InvalidInputError(
            "the frequency axis is not the one that the log book declares",
            field="freq",
            value=f"{len(freq)} lines to {freq[-1]:g} Hz",
            allowed=f"{len(axis)} lines to {axis[-1]:g} Hz",
        )
