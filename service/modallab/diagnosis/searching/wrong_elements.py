"""Several wrong elements at once: factors of all of them, reduced by backward elimination.

A search one at a time misses them: each alone closes little, and beside the others the best single one is
none of them.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.core.place import Members
from modallab.core.progress import Progress
from modallab.diagnosis.fitting.settings import FIT
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.residual import inflation_weights
from modallab.diagnosis.searching.backward_elimination import Group, backward_elimination
from modallab.diagnosis.searching.modification_screen import ModificationScreen
from modallab.diagnosis.searching.run_receptances import Exchange
from modallab.diagnosis.searching.settings import MULTIPLE_ELEMENTS
from modallab.rig.effect import Effect


def wrong_elements(
    predictor: Predictor, suspects: Sequence[Effect], progress: Progress
) -> tuple[Effect, ...]:
    """Return the fewest effects at members that together explain a measurement; none if none do.

    The factors of all members are found by Gauss-Newton steps on logarithms, of factors and of FRFs, with
    every random error inflated at first, so that they need not start near the solution. Small ones are
    drawn to 1 by iteratively reweighted least squares: Chartrand and Yin, ICASSP (2008), 3869. Backward
    elimination of the final linearisation chooses the factors that BIC supports, and neighbours of one
    factor become one effect.

    Parameters
    ----------
    suspects
        One effect for every kind and place; those that scale a matrix of one member take part.
    """
    scaling = [effect for effect in suspects if _scales_member(effect)]
    if not scaling:
        return ()
    factors = _Factors(predictor, scaling)
    solution = _all_factors(factors, progress)
    if solution.cost(0.0) > MULTIPLE_ELEMENTS.hopeless_mean_square:
        return ()
    return factors.grouped(backward_elimination(*solution.linear_model, factors.can_merge))


def _scales_member(effect: Effect) -> bool:
    specs = list(effect.specs().values())
    one_member = isinstance(effect.at, Members) and len(effect.at.numbers) == 1
    return one_member and len(specs) == 1 and specs[0].absent == 1.0


def _all_factors(factors: "_Factors", progress: Progress) -> "_Linearisation":
    """Return the linearisation at the factors of least cost."""
    current = factors.linearisation(np.zeros(len(factors)))
    stages = (*FIT.noise_inflation_schedule, 0.0)
    decision, hopeless = MULTIPLE_ELEMENTS.decision_inflation, MULTIPLE_ELEMENTS.hopeless_mean_square
    for i, noise_inflation in enumerate(stages):
        if noise_inflation < decision and current.cost(decision) > hopeless:
            break
        last_cost = np.inf
        for j in range(MULTIPLE_ELEMENTS.max_steps):
            progress((i + j / MULTIPLE_ELEMENTS.max_steps) / len(stages), "factors of all members")
            cost, step = current.cost(noise_inflation), current.step(noise_inflation)
            slow = j >= MULTIPLE_ELEMENTS.min_steps and cost > MULTIPLE_ELEMENTS.slow_ratio * last_cost
            if float(np.abs(step).max()) < MULTIPLE_ELEMENTS.tolerance or slow:
                break
            if cost > max(last_cost, hopeless):  # no convergence
                return current
            current, last_cost = factors.linearisation(current.position + step), cost
    return current


class _Linearisation:
    """Residuals at some factors, and their derivatives by the logarithm of each."""

    def __init__(self, predictor: Predictor, position: FloatArray, doubling: Sequence[Exchange]) -> None:
        self.position = position
        self._coarse = predictor.coarse_prediction(())
        screen = ModificationScreen(self._coarse, ())
        self._residual, self._derivatives = screen.unmodified, screen.derivatives(doubling)

    def cost(self, noise_inflation: float) -> float:
        """Return the mean square of the residuals, nuisance parameters projected out, errors inflated."""
        slopes, target = self._projected(noise_inflation)
        return float(np.sum((target - slopes @ self.position) ** 2)) / len(self._residual)

    def _weights(self, noise_inflation: float) -> FloatArray:
        observed = self._coarse.observed
        if not noise_inflation:
            return np.ones(len(self._residual))
        return inflation_weights(observed, observed.fitted, noise_inflation)

    def step(self, noise_inflation: float) -> FloatArray:
        """Return the step (n,) to the best factors, those near 1 drawn to it."""
        slopes, target = self._projected(noise_inflation)
        # A smooth count of the factors that are not 1, each at the penalty of BIC.
        mean_square = max(self.cost(noise_inflation), MULTIPLE_ELEMENTS.min_mean_square)
        size = self.position**2 + MULTIPLE_ELEMENTS.sparsity_scale**2
        penalty = mean_square * np.log(len(target)) / size
        best = np.linalg.solve(slopes.T @ slopes + np.diag(penalty), slopes.T @ target)
        limit = MULTIPLE_ELEMENTS.max_step
        return np.asarray((best - self.position).clip(-limit, limit))

    @property
    def linear_model(self) -> tuple[FloatArray, FloatArray]:
        """Slopes (n_data, n) and target (n_data,): target = slopes @ logarithms + noise."""
        return self._projected(0.0, 1.0)

    def _projected(
        self, noise_inflation: float, stiffness: float = MULTIPLE_ELEMENTS.prior_stiffness
    ) -> tuple[FloatArray, FloatArray]:
        """Return weighted slopes and target, projected onto the complement of the nuisance parameters."""
        weights = self._weights(noise_inflation)
        slopes = weights[:, None] * self._derivatives
        target = slopes @ self.position - weights * self._residual
        nuisances = self._coarse.nuisances
        if not len(nuisances):
            return slopes, target
        prior = stiffness * np.sqrt(nuisances.precision)
        basis = np.linalg.qr(np.vstack([weights[:, None] * nuisances.derivatives, np.diag(prior)]))[0]
        slope_rows = np.vstack([slopes, np.zeros((len(nuisances), len(self.position)))])
        target_rows = np.concatenate([target, -prior * nuisances.position])
        return slope_rows - basis @ (basis.T @ slope_rows), target_rows - basis @ (basis.T @ target_rows)


class _Factors:
    """The factors of single members, each the parameter of one effect."""

    def __init__(self, predictor: Predictor, effects: Sequence[Effect]) -> None:
        self._predictor, self._effects = predictor, effects
        self._members = [effect.at.numbers[0] for effect in effects if isinstance(effect.at, Members)]
        specs = [next(iter(effect.specs().items())) for effect in effects]
        self._names = [name for name, _ in specs]
        # A little within the bounds, as rounding must not leave them.
        least, margin = MULTIPLE_ELEMENTS.min_factor, COMPARISON_ROUNDING
        self._low = np.log([max(spec.lower * (1 + margin), least) for _, spec in specs])
        self._high = np.log([min(spec.upper * (1 - margin), 1 / least) for _, spec in specs])

    def __len__(self) -> int:
        return len(self._effects)

    def linearisation(self, position: FloatArray) -> _Linearisation:
        """Return the linearisation at logarithms (n,) of the factors, clipped to their bounds."""
        position = position.clip(self._low, self._high)
        effects = [self._effect(i, logarithm) for i, logarithm in enumerate(position)]
        return _Linearisation(
            self._predictor.folded_into_matrices(effects), position, self._doubling(effects)
        )

    def _effect(self, i: int, logarithm: float) -> Effect:
        # A linear model knows no bounds.
        factor = np.exp(np.clip(logarithm, self._low[i], self._high[i]))
        return self._effects[i].with_parameters({self._names[i]: float(factor)})

    def _doubling(self, effects: Sequence[Effect]) -> list[Exchange]:
        """Return the exchange for doubling each factor: a matrix is proportional to it."""
        run, current = self._predictor.setup.acquisition_runs[0], self._predictor.system
        for effect in effects:
            current = effect.on_system(current, run)
        doubled = [self._effect(i, np.log(2.0)).on_system(current, run) for i in range(len(self))]
        by_member = zip(doubled, self._members, strict=True)
        return [
            (system.alterations[member][1], current.alterations[member][1]) for system, member in by_member
        ]

    def can_merge(self, first: Sequence[int], second: Sequence[int]) -> bool:
        """Return whether two groups of factors may be one: of one kind, of members that share a node."""
        same_kind = len({self._effects[i].kind for i in (*first, *second)}) == 1
        return same_kind and bool(self._nodes(first) & self._nodes(second))

    def _nodes(self, indices: Sequence[int]) -> set[int]:
        table = self._predictor.system.members
        ends = dict(zip(table.numbers, table.ends, strict=True)) if table else {}
        return {node for i in indices for node in ends[self._members[i]]}

    def grouped(self, groups: Sequence[Group]) -> tuple[Effect, ...]:
        """Return one effect for each group of factors."""
        out = []
        for group in groups:
            numbers = tuple(sorted(self._members[i] for i in group.columns))
            at = None if len(numbers) == len(set(self._members)) else Members(numbers)
            out.append(replace(self._effect(group.columns[0], group.value), at=at))
        return tuple(out)
