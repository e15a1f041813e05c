"""Expected spectra of one test at few lines, leakage on a coarse grid."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from modallab.core.place import Channels
from modallab.diagnosis.residuals.channel_noise import ChannelNoise
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.settings import FREE_LEVELS
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.chain import Chain
from modallab.rig.effect import Effect, Stage, is_nonlinear
from modallab.rig.expected import coarse_spectra, narrow_in_force
from modallab.rig.run import Run
from modallab.rig.setup import RigSetup

if TYPE_CHECKING:
    from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor


@dataclass(frozen=True, eq=False)
class CoarseBase:
    """Coarse spectra of one test with some effects, of which additions in single channels change few runs.

    Nonlinear forces among the effects are taken for their equivalent linearisation, which linear additions
    keep.
    """

    effects: tuple[Effect, ...]
    """The effects."""
    spectra: CrossSpectra
    """Their spectra, before free levels are fitted."""
    noise: ChannelNoise | None
    """Noise beside them, from which fits of free levels start."""
    linearised: tuple[Run, ...] | None = None
    """Runs with the equivalent linearisation of nonlinear forces among the effects; None without any."""

    def keeps_linearisation(self, effects: Sequence[Effect]) -> bool:
        """Return whether effects are those of the base and linear additions to them."""
        n = len(self.effects)
        return tuple(effects[:n]) == self.effects and not is_nonlinear(effects[n:])

    def changed_runs(self, effects: Sequence[Effect], setup: RigSetup) -> list[int] | None:
        """Return the indices of the runs in which effects differ from the base; None: maybe in all.

        A nonlinear force that is added is linearised for all runs from the motion of the first one.
        """
        if not self.keeps_linearisation(effects):
            return None
        added = [effect.at for effect in effects[len(self.effects) :]]
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
        chain = self._chain(effects)
        linearised = chain.runs if is_nonlinear(effects) else None
        spectra = self._of_chain(chain.without_distortion)
        return CoarseBase(tuple(effects), spectra, self.observed.channel_noise(spectra), linearised)

    def predict(self, effects: Sequence[Effect], base: CoarseBase | None = None) -> Predicted:
        """Return the expected spectra with all these effects.

        Parameters
        ----------
        base
            Of a prediction like this one; runs in which effects do not differ from it are its own. While
            additions keep its linearisation, its nonlinear forces are without their distortion.
        """
        return self._predicted(self._spectra(effects, base), None if base is None else base.noise)

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
                predicted[i] = self._predicted(own, base.noise)
        return [predicted[i] for i in range(len(additions))]

    def is_narrow_in_force(self, effects: Sequence[Effect], base: CoarseBase) -> bool:
        """Return whether additions to a base may let an armature resonate on its stinger."""
        drives = any(effect.stage is Stage.DRIVE for effect in effects[len(base.effects) :])
        return drives and narrow_in_force(self._chain(effects))

    def predict_base(self, base: CoarseBase, *, distortion: bool, noise_of_all_lines: bool) -> Predicted:
        """Return the expected spectra of a base without an addition.

        Parameters
        ----------
        distortion
            Whether its nonlinear forces distort.
        noise_of_all_lines
            As in `coarse_spectra`.
        """
        distortion = distortion and base.linearised is not None
        if not (distortion or noise_of_all_lines):
            return self._predicted(base.spectra, base.noise)
        chain = self._chain(base.effects)
        chain = chain if distortion else chain.without_distortion
        spectra = self._of_chain(chain, noise_of_all_lines=noise_of_all_lines)
        return self._predicted(spectra, None if distortion else base.noise)

    def _predicted(self, spectra: CrossSpectra, noise: ChannelNoise | None) -> Predicted:
        step = FREE_LEVELS.coarse_step
        return Predicted.of(self.observed.with_levels(spectra, start=noise, last_step=step))

    def _spectra(self, effects: Sequence[Effect], base: CoarseBase | None = None) -> CrossSpectra:
        runs = None
        if base is None or not base.keeps_linearisation(effects):
            return self._of_chain(self._chain(effects))
        if self.predictor.first_setup is None:
            runs = base.changed_runs(effects, self.predictor.setup)
            if runs == []:
                return base.spectra
        linearised = base.linearised
        if linearised is not None and runs is not None:
            linearised = tuple(linearised[i] for i in runs)
        chain = self._chain(effects, linearised, runs)
        spectra = self._of_chain(chain.without_distortion)
        return spectra if runs is None else base.spectra.with_runs(runs, spectra)

    def _chain(
        self,
        effects: Sequence[Effect],
        linearised: Sequence[Run] | None = None,
        runs: Sequence[int] | None = None,
    ) -> Chain:
        share = len(self.predictor.coarse_lines) / len(self.predictor.lines)
        return self.predictor.chain(
            effects, same_in_all_runs=True, linearised=linearised, share=share, runs=runs
        )

    def _of_chain(self, chain: Chain, *, noise_of_all_lines: bool = False) -> CrossSpectra:
        step, lines = self.predictor.step, self.predictor.coarse_lines
        return coarse_spectra(chain, step, lines, noise_of_all_lines=noise_of_all_lines)
