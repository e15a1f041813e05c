"""Measured tests, their predictors, and the fit without any effect, where every search begins."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from modallab.core.dof import Dof
from modallab.core.progress import Pulse
from modallab.diagnosis.fitting.fit import Fit, fit
from modallab.diagnosis.fitting.settings import FIT
from modallab.diagnosis.fitting.visible_nuisances import with_visible_nuisances
from modallab.diagnosis.optimisation.nuisance_parameters import nuisance_parameters
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.predicting.held_out import outlying_frfs, select_held_out
from modallab.diagnosis.predicting.joint_prediction import JointPredictor
from modallab.diagnosis.predicting.prediction_budget import PredictionBudget
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.settings import BUDGET
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.frf_selection import FrfSelection
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.search_result import SearchResult
from modallab.diagnosis.searching.round_settings import ROUND
from modallab.diagnosis.searching.search_path import SearchPath
from modallab.fe.damping import UnknownDamping
from modallab.fe.structure import Structure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.rig.simulated_variance import SimulatedVariance

_FAR_FROM_DATA = ROUND.limiting_cost * FIT.near_noise  # mean square after a few steps


@dataclass(frozen=True, eq=False)
class MeasuredTests:
    """Tests of a model, and how they are predicted under any tolerances."""

    structure: Structure
    """The model."""
    measurements: Sequence[Measurement]
    """Measurements of the model."""
    hold_out_fraction: float
    """Fraction of the FRFs that takes no part in any fit."""
    hold_out: tuple[Dof, ...]
    """Responses that take no part in any case."""
    seed: int
    """Seed of the choice of held-out FRFs."""
    spared: frozenset[FrfSelection] = frozenset()
    """FRFs that are held out only if they belong to `hold_out`."""

    @cached_property
    def _simulated(self) -> tuple[SimulatedVariance, ...]:
        """Variance factors of simulated tests, one cache for each test: tolerances hardly change them."""
        return tuple(SimulatedVariance() for _ in self.measurements)

    def fit_without_effects(
        self, tolerances: Tolerances, pulse: Pulse, *, complete: bool = True
    ) -> SearchResult:
        """Return the fit under tolerances without any effect.

        Parameters
        ----------
        complete
            Whether it is fitted to its end if a few steps leave it far from the data.
        """
        predictor, unexplained, unmeasured = self._first_prediction(tolerances, pulse, complete=complete)
        return SearchResult(predictor, SearchPath(unexplained), unmeasured)

    def sparing_outliers_of(self, result: SearchResult) -> "MeasuredTests | None":
        """Return the tests without holding out the FRFs that stand out beside a result; None if none do.

        An error of a channel shows in its own FRFs alone, and a larger effect may have hidden it.
        """
        outliers = self._held_out_outliers(result.predictor, result.path.fit)
        return replace(self, spared=self.spared | outliers) if outliers else None

    def _held_out_outliers(self, predictor: Predictor, fitted: Fit) -> frozenset[FrfSelection]:
        """Return the FRFs that stand out, if one of them is held out by choice; else none."""
        observed, first = predictor.observed, self.measurements[0]
        roving_hammer = first.setup.roving_hammer
        outliers = frozenset(outlying_frfs(observed, fitted.residual, roving_hammer=roving_hammer))
        requested, _ = select_held_out(self.structure, first, 0.0, self.hold_out, self.seed)
        channels = [c for c, out in zip(observed.channels, observed.held_out, strict=True) if out]
        chosen = {frf for frf in outliers if any(map(frf.selects, channels))} - set(requested)
        return outliers if chosen else frozenset()

    def _first_prediction(
        self, tolerances: Tolerances, pulse: Pulse, *, complete: bool
    ) -> tuple[Predictor, Fit, tuple[Dof, ...]]:
        """Return the predictor, its fit without missing effects, and the held-out responses without a test.

        Only with the nuisance parameters fitted do channels with a gross error stand out; these are not held
        out.
        """
        structure, first = self.structure, self.measurements[0]
        fraction, dofs = self.hold_out_fraction, self.hold_out
        held_out, unmeasured = select_held_out(
            structure, first, fraction, dofs, self.seed, spared=self.spared
        )
        predictor = self._predictor(held_out, tolerances, pulse)
        start = _without_effects(predictor, complete=complete)
        stated = any(tolerances.stated.values())
        if stated and (outliers := self._held_out_outliers(predictor, start)):
            spared = outliers | self.spared
            held_out, _ = select_held_out(structure, first, fraction, dofs, self.seed, spared=spared)
            predictor = self._predictor(held_out, tolerances, pulse)
            start = _without_effects(predictor, complete=complete)
        return predictor, start, unmeasured

    def _predictor(self, held_out: Sequence[FrfSelection], tolerances: Tolerances, pulse: Pulse) -> Predictor:
        """Return the predictor of all tests, with nuisance parameters free within their tolerances."""
        structure, tests = self.structure, self.measurements
        observations = [observe(test, held_out, fraction=self.hold_out_fraction) for test in tests]
        budget = PredictionBudget(BUDGET.predictions_per_test * len(tests))
        first = SingleTestPredictor.of(
            structure, tests[0].setup, observations[0], heartbeat=pulse.beat, budget=budget
        )
        nuisances = nuisance_parameters(
            tolerances,
            first.system,
            _with_all_responses([test.setup for test in tests]),
            damping_unknown=isinstance(structure.damping, UnknownDamping),
        )
        first = with_visible_nuisances(first.with_nuisances(nuisances))
        budget.scale_limit(1 + len(first.nuisances) / BUDGET.nuisance_parameters)
        for _ in range(FIT.unknown_damping_fits if nuisances.damping_free else 0):
            first = first.with_nuisances_at(fit(first, ()).nuisance_position)
        follow_ups = [
            first.follow_up(test.setup, observed)
            for test, observed in zip(tests[1:], observations[1:], strict=True)
        ]
        predictors = [
            replace(predictor, simulated=simulated)
            for predictor, simulated in zip([first, *follow_ups], self._simulated, strict=True)
        ]
        return JointPredictor.of(predictors) if follow_ups else predictors[0]


def _without_effects(predictor: Predictor, *, complete: bool) -> Fit:
    """Return the fit without effects; an incomplete one is given up far from the data after a few steps."""
    if complete:
        return fit(predictor, ())
    observed = predictor.observed
    n_data = len(predictor.residual(()).vector(observed.fitted))
    return fit(predictor, (), max_chi_square=_FAR_FROM_DATA * n_data)


def is_far_from_data(fitted: Fit) -> bool:
    """Return whether a fit is so far from the data that an incomplete one is given up."""
    return fitted.chi_square > _FAR_FROM_DATA * fitted.n_data


def _with_all_responses(setups: Sequence[RigSetup]) -> RigSetup:
    """Return the first log book with the responses of all tests: each transducer has nuisances."""
    responses: dict[Dof, Dof] = {}
    for setup in setups:
        for dof in setup.responses:
            responses.setdefault(dof.point, dof)
    return replace(setups[0], responses=tuple(responses.values()))
