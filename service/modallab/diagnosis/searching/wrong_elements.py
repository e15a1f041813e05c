"""Several wrong elements at once: factors of all of them, then as few as explain as much.

One at a time they are not found: each alone closes little, and where others are missing the best single
one is none of them.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.place import Members
from modallab.core.progress import Progress
from modallab.diagnosis.fitting.settings import FIT
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.residual import inflation_weights
from modallab.diagnosis.searching.backward_elimination import Group, backward_elimination
from modallab.diagnosis.searching.modification_screen import Exchange, ModificationScreen
from modallab.rig.effect import Effect

STEPS = 8  # for each widening at most
FEW = 3  # in any case
SLOW = 0.8  # of what was left before the last step above which the next widening is as good
SMALL = 0.1  # logarithm of a factor below which it is drawn to 1, and above which it is let go
FARTHEST = 0.7  # that the logarithm of a factor goes in one step
THERE = 1e-3  # a step that changes nothing
STIFF = 10.0  # times tighter a tolerance is on the way, where no limit holds it
NONE_LEFT = 1e-6  # mean squared residual of a test without noise
WITHIN = 1e-9  # share of a bound
LEAST = 0.02  # factor that is tried
FINE = 0.03  # widening from which on what is left tells whether there is hope
HOPELESS = 3.0  # mean squared residual above which not even all factors together explain a measurement


def wrong_elements(
    predictor: Predictor, suspects: Sequence[Effect], progress: Progress
) -> tuple[Effect, ...]:
    """Return effects at members that together may explain a measurement, as few as do; none if none do.

    The factors of all members are found by Gauss-Newton steps on logarithms, of factors and of FRFs, with
    every random error widened at first, so that they need not start near their goal. Small ones are drawn
    to 1 by reweighted least squares: Chartrand and Yin, ICASSP (2008), 3869. From the straight line at the
    end those are chosen that BIC needs, and neighbours with one factor become one effect.

    Parameters
    ----------
    suspects
        One effect for every kind and place; those that multiply a matrix of one member take part.
    """
    single = [effect for effect in suspects if _multiplies(effect)]
    if not single:
        return ()
    factors = _Factors(predictor, single)
    look = _all_factors(factors, progress)
    if look.cost(0.0) > HOPELESS:
        return ()
    return factors.grouped(backward_elimination(*look.straightened, factors.together))


def _multiplies(effect: Effect) -> bool:
    specs = list(effect.specs().values())
    single = isinstance(effect.at, Members) and len(effect.at.numbers) == 1
    return single and len(specs) == 1 and specs[0].absent == 1.0


def _all_factors(factors: "_Factors", progress: Progress) -> "_Look":
    """Return a look at the factors that explain most."""
    look = factors.look(np.zeros(len(factors)))
    stages = (*FIT.noise_inflation_schedule, 0.0)
    for i, widen in enumerate(stages):
        if widen < FINE and look.cost(FINE) > HOPELESS:
            break
        before = np.inf
        for j in range(STEPS):
            progress((i + j / STEPS) / len(stages), "factors of all members")
            here, step = look.cost(widen), look.step(widen)
            if float(np.abs(step).max()) < THERE or (j >= FEW and here > SLOW * before):
                break
            if here > max(before, HOPELESS):  # it only wanders
                return look
            look, before = factors.look(look.position + step), here
    return look


class _Look:
    """Residuals at some factors, and how they change with the logarithm of each."""

    def __init__(self, predictor: Predictor, position: FloatArray, doubled: Sequence[Exchange]) -> None:
        self.position = position
        self._glimpses = predictor.coarse_prediction(())
        foreseen = ModificationScreen(self._glimpses, ())
        self._left, self._slopes = foreseen.unmodified, foreseen.derivatives(doubled)

    def cost(self, widen: float) -> float:
        """Return the mean square of what tolerances do not explain, all random errors widened."""
        slopes, target = self._cleared(widen)
        return float(np.sum((target - slopes @ self.position) ** 2)) / len(self._left)

    def _weights(self, widen: float) -> FloatArray:
        observed = self._glimpses.observed
        return inflation_weights(observed, observed.fitted, widen) if widen else np.ones(len(self._left))

    def step(self, widen: float) -> FloatArray:
        """Return the step (n,) to the best factors, those near 1 drawn to it."""
        slopes, target = self._cleared(widen)
        # A smooth count of the factors that are not 1, each worth what BIC asks for it.
        price = max(self.cost(widen), NONE_LEFT) * np.log(len(target)) / (self.position**2 + SMALL**2)
        best = np.linalg.solve(slopes.T @ slopes + np.diag(price), slopes.T @ target)
        return np.asarray((best - self.position).clip(-FARTHEST, FARTHEST))

    @property
    def straightened(self) -> tuple[FloatArray, FloatArray]:
        """Slopes (n_data, n), and the target (n_data,) that slopes @ logarithms should come near to."""
        return self._cleared(0.0, 1.0)

    def _cleared(self, widen: float, stiff: float = STIFF) -> tuple[FloatArray, FloatArray]:
        """Return slopes and target, weighed, without what numbers within their tolerances could explain."""
        weights = self._weights(widen)
        slopes = weights[:, None] * self._slopes
        target = slopes @ self.position - weights * self._left
        free = self._glimpses.nuisances
        if not len(free):
            return slopes, target
        prior = stiff * np.sqrt(free.precision)
        basis = np.linalg.qr(np.vstack([weights[:, None] * free.derivatives, np.diag(prior)]))[0]
        both = np.vstack([slopes, np.zeros((len(free), len(self.position)))])
        held = np.concatenate([target, -prior * free.position])
        return both - basis @ (basis.T @ both), held - basis @ (basis.T @ held)


class _Factors:
    """The factors of single members, each of them the number of one effect."""

    def __init__(self, predictor: Predictor, effects: Sequence[Effect]) -> None:
        self._predictor, self._effects = predictor, effects
        self._members = [effect.at.numbers[0] for effect in effects if isinstance(effect.at, Members)]
        specs = [next(iter(effect.specs().items())) for effect in effects]
        self._names = [name for name, _ in specs]
        # A little within, as rounding must not leave them.
        self._low = np.log([max(spec.lower * (1 + WITHIN), LEAST) for _, spec in specs])
        self._high = np.log([min(spec.upper * (1 - WITHIN), 1 / LEAST) for _, spec in specs])

    def __len__(self) -> int:
        return len(self._effects)

    def look(self, position: FloatArray) -> _Look:
        """Return what is left at logarithms (n,) of the factors, as far as their bounds allow."""
        position = position.clip(self._low, self._high)
        effects = [self._at(i, one) for i, one in enumerate(position)]
        return _Look(self._predictor.folded_into_matrices(effects), position, self._doubled(effects))

    def _at(self, i: int, logarithm: float) -> Effect:
        # A straight line knows no bounds.
        factor = np.exp(np.clip(logarithm, self._low[i], self._high[i]))
        return self._effects[i].with_parameters({self._names[i]: float(factor)})

    def _doubled(self, effects: Sequence[Effect]) -> list[Exchange]:
        """Return what comes and goes if each factor doubles: a matrix is in proportion to it."""
        acquisition_run, now = self._predictor.setup.acquisition_runs[0], self._predictor.system
        for effect in effects:
            now = effect.on_system(now, acquisition_run)
        twice = [self._at(i, np.log(2.0)).on_system(now, acquisition_run) for i in range(len(self))]
        each = zip(twice, self._members, strict=True)
        return [(system.alterations[number][1], now.alterations[number][1]) for system, number in each]

    def together(self, one: Sequence[int], other: Sequence[int]) -> bool:
        """Return whether factors, by their places, may be one number: of one kind, of members that meet."""
        alike = len({self._effects[i].kind for i in (*one, *other)}) == 1
        return alike and bool(self._nodes(one) & self._nodes(other))

    def _nodes(self, own: Sequence[int]) -> set[int]:
        table = self._predictor.system.members
        ends = dict(zip(table.numbers, table.ends, strict=True)) if table else {}
        return {node for i in own for node in ends[self._members[i]]}

    def grouped(self, groups: Sequence[Group]) -> tuple[Effect, ...]:
        """Return one effect for each group of factors."""
        out = []
        for group in groups:
            numbers = tuple(sorted(self._members[i] for i in group.columns))
            at = None if len(numbers) == len(set(self._members)) else Members(numbers)
            out.append(replace(self._at(group.columns[0], group.value), at=at))
        return tuple(out)
