"""Expected spectra of one test at few lines, leakage on a coarse grid."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from modallab.core.place import Channels
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.white_noise import WhiteNoise
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.effect import Effect
from modallab.rig.expected import coarse_spectra
from modallab.rig.setup import RigSetup

if TYPE_CHECKING:
    from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor


@dataclass(frozen=True, eq=False)
class CoarseBase:
    """Coarse spectra of one test with some effects, of which additions in single channels change few runs."""

    effects: tuple[Effect, ...]
    """The effects."""
    spectra: CrossSpectra
    """Their spectra, before free levels are fitted."""
    noise: WhiteNoise | None
    """Noise beside them, from which fits of free levels start."""

    def changed_runs(self, effects: Sequence[Effect], setup: RigSetup) -> list[int] | None:
        """Return the indices of the runs in which effects differ from the base; None: maybe in all.

        A nonlinear force is linearised for all runs from the motion of the first one.
        """
        n = len(self.effects)
        added = [effect.at for effect in effects[n:]]
        known = tuple(effects[:n]) == self.effects
        if not known or any(effect.on_motion() is not None for effect in effects):
            return None
        points = {point for at in added if isinstance(at, Channels) for point in at.points}
        if not all(isinstance(at, Channels) for at in added):
            return None
        outputs = [{dof.point for dof in run.outputs} for run in setup.acquisition_runs]
        return [i for i, measured in enumerate(outputs) if measured & points]

    def batches(self, additions: Sequence[Effect], setup: RigSetup) -> list[dict[int, list[int] | None]]:
        """Return additions that change separate runs together: their indices with the runs they change."""
        batches: list[dict[int, list[int] | None]] = []
        taken: list[set[int]] = []
        for i, addition in enumerate(additions):
            runs = self.changed_runs([*self.effects, addition], setup)
            needed = set(range(len(setup.acquisition_runs)) if runs is None else runs)
            place = next((k for k, others in enumerate(taken) if not others & needed), len(batches))
            if place == len(batches):
                batches.append({})
                taken.append(set())
            batches[place][i] = runs
            taken[place] |= needed
        return batches


@dataclass(frozen=True, eq=False)
class CoarseSpectra:
    """Predicts one test at every `step`-th line of its predictor."""

    predictor: "SingleTestPredictor"
    """The predictor of all lines."""
    observed: Observed
    """Measured spectra at the coarse lines."""

    def base(self, effects: Sequence[Effect]) -> CoarseBase:
        """Return the spectra of some effects, for predictions of additions to them."""
        spectra = self._spectra(effects)
        return CoarseBase(tuple(effects), spectra, self.observed.white_noise(spectra))

    def predict(self, effects: Sequence[Effect], base: CoarseBase | None = None) -> Predicted:
        """Return the expected spectra with all these effects.

        Parameters
        ----------
        base
            Of a prediction like this one; runs in which effects do not differ from it are its own.
        """
        start = None if base is None else base.noise
        return Predicted.of(self.observed.with_levels(self._spectra(effects, base), start=start))

    def predict_each(self, additions: Sequence[Effect], base: CoarseBase) -> list[Predicted]:
        """Return the expected spectra of the effects of a base with each of some additions.

        Additions that change separate runs are predicted by one chain.
        """
        predictor = self.predictor
        if predictor.first_setup is not None:
            return [self.predict([*base.effects, addition], base) for addition in additions]
        predicted: dict[int, Predicted] = {}
        for batch in base.batches(additions, predictor.setup):
            together = self._spectra([*base.effects, *(additions[i] for i in batch)], base)
            for i, runs in batch.items():
                own = together if runs is None else base.spectra.with_runs(runs, together.of_runs(runs))
                predicted[i] = Predicted.of(self.observed.with_levels(own, start=base.noise))
        return [predicted[i] for i in range(len(additions))]

    def _spectra(self, effects: Sequence[Effect], base: CoarseBase | None = None) -> CrossSpectra:
        predictor, runs = self.predictor, None
        if base is not None and predictor.first_setup is None:
            runs = base.changed_runs(effects, predictor.setup)
            if runs == []:
                return base.spectra
        share = len(predictor.coarse_lines) / len(predictor.lines)
        chain = predictor.chain(effects, same_in_all_runs=True, share=share, runs=runs)
        spectra = coarse_spectra(chain, predictor.step, predictor.coarse_lines)
        return spectra if base is None or runs is None else base.spectra.with_runs(runs, spectra)
