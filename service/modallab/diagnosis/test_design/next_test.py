"""Which further test would tell two explanations apart, foreseen by simulating both."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import ModalLabError
from modallab.core.progress import Progress
from modallab.diagnosis.predicting.joint_prediction import FollowUpPredictor
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.observed import Observed, observe
from modallab.diagnosis.residuals.residual import residual
from modallab.diagnosis.result import NextTest
from modallab.diagnosis.test_design.follow_up_tests import FurtherTest, further_tests
from modallab.rig.change import Change
from modallab.rig.effect import Effect
from modallab.rig.expected import coarse_spectra
from modallab.rig.measure import measurement_of
from modallab.rig.setup import RigSetup

SURE = 5.0  # standard deviations that count as telling two explanations apart
USELESS = 1.0  # below which a test is not worth proposing
NUDGE = 1e-4  # of a parameter, to differentiate by: far above rounding, far below any curvature

Look = Callable[[Sequence[Effect]], FloatArray]  # residuals of effects


@dataclass(frozen=True, eq=False)
class Explanation:
    """Effects with the values that were fitted to the tests done so far."""

    effects: tuple[Effect, ...]
    kind: str  # of the effect in which it differs from the others
    position: FloatArray | None = None  # of what is tolerated beside them; None: all as declared

    def told_to(self, predictor: Predictor) -> Predictor:
        """Return a predictor with what is tolerated where the fit has it."""
        return predictor if self.position is None else predictor.with_nuisances_at(self.position)

    @cached_property
    def perturbed(self) -> list[tuple[list[Effect], float]]:
        """The effects with one parameter moved a little, and by how much, for each parameter."""
        moved = []
        for i, effect in enumerate(self.effects):
            for name, spec in effect.specs().items():
                value = effect.parameters[name]
                by = NUDGE * (abs(value) or abs(type(effect)().parameters[name]) or 1.0)
                by = by if value + by <= spec.upper else -by
                other = effect.with_parameters({name: value + by})
                moved.append(([*self.effects[:i], other, *self.effects[i + 1 :]], by))
        return moved

    def derivatives(self, look: Look, base: FloatArray) -> FloatArray:
        """Return how residuals change with the parameters, (n_data, n_parameters).

        Parameters
        ----------
        look
            Residuals of effects.
        base
            Of these.
        """
        columns = [(look(effects) - base) / by for effects, by in self.perturbed]
        return np.array(columns).reshape(len(columns), len(base)).T


def propose(
    predictor: Predictor,
    best: Explanation,
    rivals: Sequence[Explanation],
    *,
    done: Sequence[Change] = (),
    progress: Progress,
) -> NextTest | None:
    """Return the cheapest further test that tells an explanation from its rivals, or else the best one.

    Expected is how far the prediction of either lies from what the other can be fitted to, in standard
    deviations of the new test's random error: the root of the growth of chi-square of all tests together,
    linear in the parameters, which the tests done so far hold with their own sensitivity.

    Parameters
    ----------
    done
        Changes of tests that were done already.

    Returns
    -------
    None if no test that was considered tells them apart by as much as a standard deviation.
    """
    first = predictor.tests[0]
    everyone = [best, *rivals]
    known = [_Known(predictor, one) for one in everyone]
    options = [t for t in further_tests(first.setup, first.system) if t.change not in done]
    found: list[tuple[FurtherTest, FloatArray]] = []
    for i, option in enumerate(options):
        progress(i / len(options), "looking for a test that tells more")
        try:
            setup = option.change.applied(first.setup)
            test = _Foreseen(first, setup)
            apart = test.apart(everyone, [one.held for one in known])
            if apart.max() >= USELESS and len(first.nuisances):
                # What is tolerated can only hide a difference: it is worked out where there is one.
                apart = test.apart(everyone, [one.all_held for one in known], tolerating=True)
        except ModalLabError:
            continue  # a test that this rig cannot do, or whose outcome cannot be foreseen
        found.append((option, apart))
        if apart.min() >= SURE:
            break
    if not found:
        return None
    option, apart = max(found, key=lambda one: (int((one[1] >= SURE).sum()), one[1].min(), one[1].max()))
    return _worded(option, apart, best, rivals)


def _worded(
    option: FurtherTest, apart: FloatArray, best: Explanation, rivals: Sequence[Explanation]
) -> NextTest | None:
    told = np.flatnonzero(apart >= SURE)
    if not told.size:
        told = np.flatnonzero(apart >= USELESS)
    if not told.size:
        return None
    expected = float(apart[told].min())
    names = tuple(dict.fromkeys([best.kind, *(rivals[int(i)].kind for i in told)]))
    sure = "" if expected >= SURE else "; no test that was considered is sure to tell, this one comes nearest"
    return NextTest(f"{option.why}{sure}", option.change.plain, names, expected)


class _Foreseen:
    """A test that has not been done: what each explanation predicts for it, at every few lines."""

    def __init__(self, first: Predictor, setup: RigSetup) -> None:
        # Nothing was observed there; what one explanation predicts will stand for it.
        self._predictor = FollowUpPredictor(first, setup, first.observed)
        self._setup = setup

    def apart(
        self, everyone: Sequence[Explanation], held: Sequence[FloatArray], *, tolerating: bool = False
    ) -> FloatArray:
        """Return by how many standard deviations each rival lies from the first explanation, (n_rivals,).

        Parameters
        ----------
        held
            (n, n_numbers) sensitivity of the tests done so far to each one's numbers.
        tolerating
            Whether what is tolerated is among them.
        """
        best, seen = everyone[0], [self._seen(one) for one in everyone]
        out = []
        for r, rival in enumerate(everyone[1:], 1):
            there = self._beyond(seen[0], best, rival, held[r], tolerating)
            back = self._beyond(seen[r], rival, best, held[0], tolerating)
            out.append(min(there, back))
        return np.array(out)

    def _seen(self, explanation: Explanation) -> Observed:
        """Return the test as it would be seen if the explanation were right, without random error."""
        predictor = explanation.told_to(self._predictor)
        spectra = coarse_spectra(predictor.chain(explanation.effects), predictor.step)
        return observe(measurement_of(spectra, self._setup), (), fraction=0.0)

    def _look(self, seen: Observed, explanation: Explanation) -> Look:
        predictor = explanation.told_to(self._predictor)
        return lambda effects: residual(seen, predictor.coarse(effects)).vector(seen.usable)

    def _beyond(
        self, seen: Observed, true: Explanation, other: Explanation, held: FloatArray, tolerating: bool
    ) -> float:
        """Return how far an explanation stays from a test that another made, re-fitted as well as may be."""
        look = self._look(seen, other)
        begin = look(other.effects)
        difference = begin - self._look(seen, true)(true.effects)
        slopes = other.derivatives(look, begin)
        if tolerating:
            slopes = np.hstack([slopes, self._tolerated(seen, other)])
        weight = np.sqrt(self._predictor.step / seen.correlation_length)
        rows = np.vstack([weight * slopes, held])
        wanted = np.concatenate([weight * difference, np.zeros(len(held))])
        size = np.linalg.norm(rows, axis=0) + 1e-300  # parameters differ by many powers of ten
        step = np.linalg.lstsq(rows / size, -wanted, rcond=None)[0]
        return float(np.linalg.norm(wanted + (rows / size) @ step))

    def _tolerated(self, seen: Observed, explanation: Explanation) -> FloatArray:
        """Return how residuals change with what is tolerated, (n_data, n)."""
        predictor = explanation.told_to(self._predictor)
        return predictor.nuisances.derivatives(
            lambda more: predictor.coarse([*more, *explanation.effects]),
            lambda predicted: residual(seen, predicted).vector(seen.usable),
            predictor.coarse(explanation.effects),
            seen,
            np.arange(len(predictor.nuisances)),
        )


class _Known:
    """How the tests done so far hold the numbers of an explanation.

    Of many residuals as few as there are numbers: the triangle of a QR factorisation.
    """

    def __init__(self, predictor: Predictor, explanation: Explanation) -> None:
        predictor = explanation.told_to(predictor)
        self._explanation, self._glimpses = explanation, predictor.coarse_prediction(explanation.effects)
        self._weight = np.sqrt(predictor.step / self._glimpses.observed.correlation_length)

    @cached_property
    def _own(self) -> FloatArray:
        glimpses, observed = self._glimpses, self._glimpses.observed

        def look(effects: Sequence[Effect]) -> FloatArray:
            return residual(observed, glimpses.predict(effects)).vector(observed.fitted)

        return np.asarray(self._weight * self._explanation.derivatives(look, look(self._explanation.effects)))

    @cached_property
    def held(self) -> FloatArray:
        """(n, n_parameters), of the parameters alone."""
        return np.asarray(np.linalg.qr(self._own, mode="r"))

    @cached_property
    def all_held(self) -> FloatArray:
        """(n, n_parameters + n), of what is tolerated too, which its prior holds as well."""
        also = self._weight * self._glimpses.derivatives
        prior = np.hstack([np.zeros((also.shape[1], self._own.shape[1])), np.eye(also.shape[1])])
        return np.asarray(np.linalg.qr(np.vstack([np.hstack([self._own, also]), prior]), mode="r"))
