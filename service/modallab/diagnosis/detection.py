"""Detection limits: the smallest effects that a test would still have shown."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.core.place import Channels
from modallab.core.progress import Progress
from modallab.diagnosis.fitting.fit import Fit
from modallab.diagnosis.optimisation.bounded_quadratic import BoundedQuadratic
from modallab.diagnosis.optimisation.linear_nuisances import LinearNuisances
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.residual import gap_errors, residual
from modallab.diagnosis.result import DetectionLimit
from modallab.diagnosis.searching.acceptance import variance_inflation
from modallab.diagnosis.searching.gap_tests import largest_gap_by_chance
from modallab.diagnosis.searching.modification_screen import ModificationScreen
from modallab.diagnosis.searching.settings import ACCEPTANCE
from modallab.diagnosis.searching.starting_values import scan_sizes, smallest_amounts, with_amount_scaled
from modallab.diagnosis.settings import DIAGNOSIS
from modallab.rig.effect import Effect, Stage

GRADUAL_STAGES = (Stage.STRUCTURE, Stage.DRIVE, Stage.CHANNEL)
"""Stages whose effects change spectra in proportion to a small amount."""


def detection_limits(
    predictor: Predictor, found: Fit, suspects: Sequence[Effect], progress: Progress
) -> tuple[DetectionLimit, ...]:
    """Return the detection limit of each kind of suspect at its most and its least visible place.

    A limit is the amount at which an effect, hidden beside those found, is expected to raise the gap of a
    part of the measurement beyond chance and to be significant, by two standard deviations both. Nuisance
    parameters and the effects found are free. To first order at every place; by predictions near the limit
    at the two places of a kind. Effects whose amount alone does not describe them (resonances, nonlinear
    forces, signals) have no limit.

    Parameters
    ----------
    found
        The fit that leaves random error alone.
    suspects
        One effect for every kind and place.
    """
    gradual = [
        effect for effect in suspects if _is_gradual(effect, predictor) and _is_fitted(effect, predictor)
    ]
    visibility = _Visibility(predictor, found)
    limits: dict[str, list[Effect | None]] = {}
    for i, suspect in enumerate(gradual):
        progress(i / len(gradual), f"detection limit of {suspect.kind}")
        limits.setdefault(suspect.kind, []).append(visibility.first_order_limit(suspect))
    summaries = [_summary(visibility, of_kind) for of_kind in limits.values()]
    return tuple(summary for summary in summaries if summary is not None)


def _is_gradual(effect: Effect, predictor: Predictor) -> bool:
    """Return whether an effect is described by its amount, and small where the amount is."""
    specs = list(effect.specs().values())
    if not specs or effect.on_motion() is not None or effect.intermittent:
        return False
    amount, *shapes = specs
    neutral = amount.absent
    return (
        effect.stage in GRADUAL_STAGES
        and neutral is not None
        and neutral < amount.upper
        and not any(shape.scan_values for shape in shapes)
        and not effect.scan_values(predictor.system, predictor.setup)
    )


def _is_fitted(effect: Effect, predictor: Predictor) -> bool:
    """Return whether an effect acts on data that are fitted; one of single channels may not."""
    if not isinstance(effect.at, Channels):
        return True
    observed = predictor.observed
    channels = zip(observed.channels, observed.held_out, strict=True)
    fitted = {channel.response.point for channel, held_out in channels if not held_out}
    return bool(fitted & set(effect.at.points))


def _is_on_bound(effect: Effect) -> bool:
    """Return whether the amount of an effect is the largest or the smallest that it can be."""
    name, spec = next(iter(effect.specs().items()))
    return not spec.lower < effect.parameters[name] < spec.upper


def _deviation(effect: Effect) -> float:
    """Return how far the amount of an effect is from that of none."""
    name, spec = next(iter(effect.specs().items()))
    return abs(effect.parameters[name] - (spec.absent or 0.0))


def _summary(visibility: "_Visibility", limits: Sequence[Effect | None]) -> DetectionLimit | None:
    """Return the limits of a kind from those to first order at all its places; None if it is not visible.

    Parameters
    ----------
    limits
        None where no amount is visible.
    """
    by_first_order = sorted((effect for effect in limits if effect is not None), key=_deviation)
    hidden, last = len(limits) - len(by_first_order), None
    for effect in reversed(by_first_order):
        last = visibility.limit(effect)
        if last is not None:
            break
        hidden += 1
    first = last if len(by_first_order) == 1 else _most_visible(visibility, by_first_order)
    if first is None or last is None:
        return None
    name, spec = next(iter(first.specs().items()))
    return DetectionLimit(
        first.kind, name, spec.unit, _deviation(first), first.at, _deviation(last), last.at, hidden
    )


def _most_visible(visibility: "_Visibility", by_first_order: Sequence[Effect]) -> Effect | None:
    """Return the smallest limit of a kind; a limit is never below that to first order."""
    best: Effect | None = None
    for effect in by_first_order:
        if best is not None and _deviation(best) <= _deviation(effect):
            return best
        refined = visibility.limit(effect)
        if refined is not None:
            best = refined if best is None else min(best, refined, key=_deviation)
    return best


class _Visibility:
    """How much small effects change the residuals beyond what nuisance parameters take up."""

    def __init__(self, predictor: Predictor, found: Fit) -> None:
        self._found = found
        near = predictor.with_nuisances_at(found.nuisance_position)
        prediction = self._prediction = near.coarse_prediction(found.effects)
        self._mask = prediction.observed.fitted
        # Coarse lines stand for all of them.
        self._weight = float(np.sqrt(predictor.observed.fitted.sum() / max(self._mask.sum(), 1)))
        self._residual = residual(prediction.observed, prediction.predict(found.effects))
        self._base = self._residual.vector(self._mask)
        self._screen = ModificationScreen(prediction, found.effects)
        self._sizes = self._residual.sizes_by_part(self._mask)
        self._nuisances = _Nuisances(prediction.nuisances, list(self._sizes.values()), weight=self._weight)
        self._excess = _excess_of_parts(predictor, found)
        self._inflation = variance_inflation(predictor, found)

    def first_order_limit(self, suspect: Effect) -> Effect | None:
        """Return a suspect with the amount of its detection limit to first order; None: not visible."""
        sizes = scan_sizes(suspect, {})
        smallest = smallest_amounts(sizes)
        if not smallest:
            return None
        effect = sizes[smallest[-1]]
        size = float(np.linalg.norm(self._weight * self._change(effect)))
        if size == 0:
            return None
        return self._at_limit(with_amount_scaled(effect, min(1.0, DIAGNOSIS.detection_step / size)))

    def limit(self, first_order: Effect) -> Effect | None:
        """Return an effect with the amount of its detection limit; None if no amount is visible.

        The larger one of two: to first order, and by predictions near the limit. Nuisance parameters that
        imitate an effect leave its curvature, which they would take up too where they are large; and an
        effect whose change grows less than its amount is seen later than to first order.
        """
        near: Effect | None = first_order
        for _ in range(DIAGNOSIS.detection_evaluations):
            near = None if near is None else self._at_limit(near)
        return None if near is None else max(first_order, near, key=_deviation)

    def _at_limit(self, effect: Effect) -> Effect | None:
        """Return an effect with the amount at which it would be visible; None if it has no such amount."""
        factor = self._factor(effect)
        enlarged = with_amount_scaled(effect, factor) if np.isfinite(factor) else None
        return None if enlarged is None or _is_on_bound(enlarged) else enlarged

    def _factor(self, effect: Effect) -> float:
        """Return the factor by which an amount has to grow to be detected; inf if it changes nothing."""
        change = self._nuisances.beside(self._weight * self._change(effect))
        gain = change.gain
        if not gain > 0:
            return np.inf
        cost = len(effect.fitted_specs()) * self._found.cost_per_parameter
        least = np.sqrt(cost + ACCEPTANCE.very_strong_bic * self._inflation) + DIAGNOSIS.detection_margin
        return self._gap_factor_with_nuisances(change, float(least / np.sqrt(gain)))

    def _gap_factor_with_nuisances(self, change: "_ChangeBesideNuisances", least: float) -> float:
        """Return the factor by which a change of residuals has to grow to raise a part of the gap.

        Between what it is if nuisance parameters take up nothing and if they have no bounds.

        Parameters
        ----------
        least
            Least factor.
        """
        high = max(least, self._gap_factor(change.remaining))
        if change.is_taken_up_within_bounds(high):
            return high
        low = max(least, self._gap_factor(change.squares))
        for _ in range(DIAGNOSIS.detection_bisections if high > low else 0):
            middle = float(np.sqrt(low * high))
            seen = self._gap_factor(change.remaining_within_bounds(middle)) <= 1
            low, high = (low, middle) if seen else (middle, high)
        return high

    def _gap_factor(self, squares: FloatArray) -> float:
        """Return the factor by which a change has to grow, of weighted squares (n_parts,) by part."""
        raised = squares / self._weight**2 / list(self._sizes.values())
        excess = np.array([self._excess[part] for part in self._sizes])
        return float(np.sqrt(excess / np.maximum(raised, SAFE_DIVISOR)).min())

    def _change(self, effect: Effect) -> FloatArray:
        """Return the change of the residuals (n_data,) by an effect."""
        vectors = self._screen.residuals([effect])
        if vectors is not None:
            return np.asarray(vectors[0] - self._screen.unmodified)
        predicted = self._prediction.predict([*self._found.effects, effect])
        return residual(self._prediction.observed, predicted).vector(self._mask) - self._base


class _Nuisances:
    """Nuisance parameters that take up a part of a change of residuals, to first order under their prior."""

    def __init__(self, nuisances: LinearNuisances, sizes: Sequence[int], *, weight: float) -> None:
        self._ends = np.cumsum(sizes)[:-1]
        derivatives = weight * nuisances.derivatives.reshape(sum(sizes), -1)
        self._parts = np.split(derivatives, self._ends)
        self.curvatures = np.array([part.T @ part for part in self._parts])  # (n_parts, n, n)
        self.precision = nuisances.precision
        self.low, self.high = (bound - nuisances.position for bound in (nuisances.low, nuisances.high))
        self.quadratic = BoundedQuadratic(self.curvatures.sum(axis=0) + np.diag(nuisances.precision))

    def beside(self, change: FloatArray) -> "_ChangeBesideNuisances":
        """Return a change of residuals (n_residuals,) beside the nuisance parameters."""
        pieces = np.split(change, self._ends)
        return _ChangeBesideNuisances(
            self,
            np.array([piece @ piece for piece in pieces]),
            np.array([part.T @ piece for part, piece in zip(self._parts, pieces, strict=True)]),
        )


@dataclass(frozen=True, eq=False)
class _ChangeBesideNuisances:
    """A change of residuals by its products: many factors of it cost no product of residuals."""

    nuisances: _Nuisances
    squares: FloatArray
    """(n_parts,) sums of its squares."""
    products: FloatArray
    """(n_parts, n) with the derivatives by nuisance parameters."""

    @cached_property
    def _shift(self) -> FloatArray:
        """(n,) shift of the nuisance parameters, without bounds."""
        free = np.full(len(self._gradient), np.inf)
        return self.nuisances.quadratic.minimise(self._gradient, -free, free)

    @property
    def _gradient(self) -> FloatArray:
        return np.asarray(self.products.sum(axis=0))

    @property
    def gain(self) -> float:
        """Chi-square of what they leave of it, and of their prior."""
        return float(self.remaining.sum() + self.nuisances.precision @ self._shift**2)

    @property
    def remaining(self) -> FloatArray:
        """(n_parts,) squares of what they leave of it, without bounds."""
        return self._remaining(1.0, self._shift)

    def is_taken_up_within_bounds(self, factor: float) -> bool:
        """Return whether they take up so many times the change within their bounds."""
        shift = factor * self._shift
        return bool(((self.nuisances.low <= shift) & (shift <= self.nuisances.high)).all())

    def remaining_within_bounds(self, factor: float) -> FloatArray:
        """Return the squares (n_parts,) of what they leave of so many times the change."""
        low, high = self.nuisances.low, self.nuisances.high
        return self._remaining(factor, self.nuisances.quadratic.minimise(factor * self._gradient, low, high))

    def _remaining(self, factor: float, shift: FloatArray) -> FloatArray:
        own = factor**2 * self.squares + 2 * factor * self.products @ shift
        return np.maximum(own + self.nuisances.curvatures @ shift @ shift, 0.0)


def _excess_of_parts(predictor: Predictor, found: Fit) -> dict[str, float]:
    """Return how far the gap of each part has to rise to be seen almost always."""
    observed = predictor.observed
    errors = gap_errors(observed, found.residual, observed.fitted, max_lag=ACCEPTANCE.correlated_lines)
    margin = DIAGNOSIS.detection_margin
    combined = {part: float(np.hypot(error, observed.scale_error)) for part, error in errors.items()}
    return {part: largest_gap_by_chance(error) - 1 + margin * error for part, error in combined.items()}
