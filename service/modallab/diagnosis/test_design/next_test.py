"""Choice of the further test that distinguishes explanations, by simulation of each."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import ModalLabError
from modallab.core.numerics import SAFE_DIVISOR
from modallab.core.progress import Progress
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import residual
from modallab.diagnosis.result import NextTest
from modallab.diagnosis.test_design.follow_up_tests import FollowUpOption, follow_up_options
from modallab.diagnosis.test_design.settings import SEPARATION
from modallab.rig.change import Change
from modallab.rig.effect import Effect
from modallab.rig.expected import coarse_spectra
from modallab.rig.measure import measurement_of
from modallab.rig.setup import RigSetup

ResidualFunction = Callable[[Sequence[Effect]], FloatArray]  # whitened residual vector of effects


AnyPredictor = TypeVar("AnyPredictor", bound=Predictor)


@dataclass(frozen=True, eq=False)
class Explanation:
    """Effects with the parameters fitted to the tests done so far."""

    effects: tuple[Effect, ...]
    """Fitted effects."""
    kind: str
    """Kind of the effect in which this explanation differs from its rivals."""
    position: FloatArray | None = None
    """(n_nuisances,) fitted nuisance parameters; None: all as declared."""

    def applied_to(self, predictor: AnyPredictor) -> AnyPredictor:
        """Return the predictor with the nuisance parameters of this explanation."""
        return predictor if self.position is None else predictor.with_nuisances_at(self.position)

    @cached_property
    def perturbed(self) -> list[tuple[list[Effect], float]]:
        """The effects with one parameter perturbed, and the step, for each parameter."""
        perturbations = []
        for i, effect in enumerate(self.effects):
            for name, spec, _ in effect.fitted_specs():
                value = effect.parameters[name]
                scale = abs(value) or abs(type(effect)().parameters[name]) or 1.0
                step = SEPARATION.difference_step * scale
                step = step if value + step <= spec.upper else -step
                perturbed = effect.with_parameters({name: value + step})
                perturbations.append(([*self.effects[:i], perturbed, *self.effects[i + 1 :]], step))
        return perturbations

    def jacobian(self, residual_of: ResidualFunction, base: FloatArray) -> FloatArray:
        """Return the derivatives of residuals with respect to the parameters, (n_data, n_parameters).

        Parameters
        ----------
        residual_of
            Residual vector of effects.
        base
            (n_data,) residual vector of the effects of this explanation.
        """
        columns = [(residual_of(effects) - base) / step for effects, step in self.perturbed]
        return np.array(columns).reshape(len(columns), len(base)).T


def propose(
    predictor: Predictor,
    best: Explanation,
    rivals: Sequence[Explanation],
    *,
    previous_changes: Sequence[Change] = (),
    progress: Progress,
) -> NextTest | None:
    """Return the cheapest further test that distinguishes an explanation from its rivals, or the best one.

    The expected separation of two explanations is the distance of the prediction of either from the best
    re-fit of the other, in standard deviations of the new test's random error: the root of the growth of
    chi-square of all tests together, linearised in the parameters, with the information of the tests done
    so far on them.

    Parameters
    ----------
    best, rivals
        The named explanation, and those that are not excluded.
    previous_changes
        Changes of tests that were done already.

    Returns
    -------
    NextTest or None
        None if no test that was considered separates any two by a standard deviation.
    """
    first = predictor.tests[0]
    explanations = [best, *rivals]
    information = [_PriorInformation(predictor, explanation) for explanation in explanations]
    options = [
        option
        for option in follow_up_options(first.setup, first.system)
        if option.change not in previous_changes
    ]
    candidates: list[tuple[FollowUpOption, FloatArray]] = []
    for i, option in enumerate(options):
        progress(i / len(options), "simulating further tests")
        try:
            test = _SimulatedTest(first, option.change.applied(first.setup))
            separation = test.separations(explanations, [prior.factor for prior in information])
            if separation.max() >= SEPARATION.useful and len(first.nuisances):
                # Nuisance parameters can only reduce a separation, so they are left out where there is none.
                factors = [prior.factor_with_nuisances for prior in information]
                separation = test.separations(explanations, factors, nuisances=True)
        except ModalLabError:
            continue  # this rig cannot do the test, or its outcome cannot be predicted
        candidates.append((option, separation))
        if separation.min() >= SEPARATION.certain:
            break
    if not candidates:
        return None
    option, separation = max(candidates, key=_order_of_merit)
    return _proposal(option, separation, best, rivals)


def _order_of_merit(candidate: tuple[FollowUpOption, FloatArray]) -> tuple[int, float, float]:
    """Return the number of excluded rivals, then the least and the largest separation."""
    _, separation = candidate
    return int((separation >= SEPARATION.certain).sum()), float(separation.min()), float(separation.max())


def _proposal(
    option: FollowUpOption, separation: FloatArray, best: Explanation, rivals: Sequence[Explanation]
) -> NextTest | None:
    separated = np.flatnonzero(separation >= SEPARATION.certain)
    if not separated.size:
        separated = np.flatnonzero(separation >= SEPARATION.useful)
    if not separated.size:
        return None
    expected = float(separation[separated].min())
    names = tuple(dict.fromkeys([best.kind, *(rivals[int(i)].kind for i in separated)]))
    caveat = "; no test is certain to distinguish them, this one comes nearest"
    why = option.why if expected >= SEPARATION.certain else f"{option.why}{caveat}"
    return NextTest(why, option.change.plain, names, expected)


class _SimulatedTest:
    """Further test, as each explanation predicts it, on a subset of the lines."""

    def __init__(self, first: SingleTestPredictor, setup: RigSetup) -> None:
        # The observation of the first test is a placeholder: the prediction of an explanation replaces it.
        self._predictor = first.plan(setup)
        self._setup = setup

    def separations(
        self, explanations: Sequence[Explanation], factors: Sequence[FloatArray], *, nuisances: bool = False
    ) -> FloatArray:
        """Return the separation of each rival from the first explanation, standard deviations, (n_rivals,).

        Parameters
        ----------
        factors
            (n, n_parameters) R factor of the information of the tests done so far, of each explanation.
        nuisances
            Whether the nuisance parameters are among the parameters.
        """
        best, observed = explanations[0], [self._observation(explanation) for explanation in explanations]
        separations = []
        for r, rival in enumerate(explanations[1:], 1):
            forward = self._distance(observed[0], best, rival, factors[r], nuisances)
            reverse = self._distance(observed[r], rival, best, factors[0], nuisances)
            separations.append(min(forward, reverse))
        return np.array(separations)

    def _observation(self, explanation: Explanation) -> Observed:
        """Return the observation of the test if the explanation is true, without random error."""
        predictor = explanation.applied_to(self._predictor)
        measuring_chain = predictor.chain(explanation.effects)
        spectra = coarse_spectra(measuring_chain, predictor.step, predictor.coarse_lines)
        return observe(measurement_of(spectra, self._setup), (), fraction=0.0)

    def _residual_function(self, observed: Observed, explanation: Explanation) -> ResidualFunction:
        predictor = explanation.applied_to(self._predictor)
        return lambda effects: residual(observed, predictor.coarse(effects)).vector(observed.usable)

    def _distance(
        self,
        observed: Observed,
        true: Explanation,
        rival: Explanation,
        factor: FloatArray,
        nuisances: bool,
    ) -> float:
        """Return the distance of a rival, after its best linear re-fit, from the true explanation's test."""
        residual_of = self._residual_function(observed, rival)
        base = residual_of(rival.effects)
        difference = base - self._residual_function(observed, true)(true.effects)
        jacobian = rival.jacobian(residual_of, base)
        if nuisances:
            jacobian = np.hstack([jacobian, self._nuisance_jacobian(observed, rival)])
        weight = np.sqrt(self._predictor.step / observed.correlation_length)
        rows = np.vstack([weight * jacobian, factor])
        target = np.concatenate([weight * difference, np.zeros(len(factor))])
        scale = np.linalg.norm(rows, axis=0) + SAFE_DIVISOR  # parameters differ by many powers of ten
        step = np.linalg.lstsq(rows / scale, -target, rcond=None)[0]
        return float(np.linalg.norm(target + (rows / scale) @ step))

    def _nuisance_jacobian(self, observed: Observed, explanation: Explanation) -> FloatArray:
        """Return the derivatives of residuals with respect to the nuisances, (n_data, n_nuisances)."""
        predictor = explanation.applied_to(self._predictor)
        return predictor.nuisances.derivatives(
            lambda more: predictor.coarse([*more, *explanation.effects]),
            lambda predicted: residual(observed, predicted).vector(observed.usable),
            predictor.coarse(explanation.effects),
            observed,
            predictor.position,
            np.arange(len(predictor.nuisances)),
        )


class _PriorInformation:
    """Information of the tests done so far on the parameters of an explanation.

    The R factor of a QR factorisation of the whitened Jacobian stands for all of its rows.
    """

    def __init__(self, predictor: Predictor, explanation: Explanation) -> None:
        predictor = explanation.applied_to(predictor)
        self._explanation, self._prediction = explanation, predictor.coarse_prediction(explanation.effects)
        self._weight = np.sqrt(predictor.step / self._prediction.observed.correlation_length)

    @cached_property
    def _jacobian(self) -> FloatArray:
        prediction, observed = self._prediction, self._prediction.observed

        def residual_of(effects: Sequence[Effect]) -> FloatArray:
            return residual(observed, prediction.predict(effects)).vector(observed.fitted)

        base = residual_of(self._explanation.effects)
        return np.asarray(self._weight * self._explanation.jacobian(residual_of, base))

    @cached_property
    def factor(self) -> FloatArray:
        """(n, n_parameters), R factor of the effects' parameters alone."""
        return np.asarray(np.linalg.qr(self._jacobian, mode="r"))

    @cached_property
    def factor_with_nuisances(self) -> FloatArray:
        """(n, n_parameters + n_nuisances), R factor with the nuisance parameters and their unit prior."""
        nuisances = self._weight * self._prediction.derivatives
        n = nuisances.shape[1]
        prior = np.hstack([np.zeros((n, self._jacobian.shape[1])), np.eye(n)])
        return np.asarray(np.linalg.qr(np.vstack([np.hstack([self._jacobian, nuisances]), prior]), mode="r"))
