"""Identifiability of coefficients by measured data: null space, confidence intervals and weak directions."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from modallab.core.arrays import FloatArray, frozen
from modallab.core.reply import NanFloat, Vector
from modallab.updating.log_coefficients import log_derivatives
from modallab.updating.parameterisation import MacroElement, Parameterisation, Part
from modallab.updating.settings import IDENTIFIABILITY
from modallab.updating.solve import ParameterStep


@dataclass(frozen=True, eq=False)
class Direction:
    """Joint relative change of coefficients that the data determine poorly or not at all."""

    macros: tuple[MacroElement, ...]
    """(n_macros,) macro elements with a named share."""
    shares: Vector
    """Relative changes of these coefficients (n_macros,); the squares of all coefficients' shares add up to
    one.
    """
    standard_error: float | None
    """Standard error of the relative change along the direction; None in the null space."""
    words: str
    """Description of the ambiguity, without full stop."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "shares", frozen(self.shares, float, (len(self.macros),), name="shares"))


@dataclass(frozen=True, eq=False)
class Identifiability:
    """Determination of coefficients by the data alone, without any prior."""

    macros: tuple[MacroElement, ...]
    """(n_params,) macro element of each coefficient."""
    singular_values: Vector
    """Of the weighted sensitivity matrix, in falling order."""
    rank: int
    """Rank of the weighted sensitivity matrix."""
    condition_number: NanFloat
    """Largest over smallest singular value within the rank."""
    covariance: FloatArray | None
    """Covariance of the coefficients (n_params, n_params) within the rank; None without an error estimate."""
    intervals: FloatArray
    """95 % confidence intervals within the bounds (n_params, 2)."""
    unidentified: tuple[MacroElement, ...]
    """Macro elements with a relative standard error above `identified_within`."""
    directions: tuple[Direction, ...]
    """Poorly determined directions, those of the null space first."""

    def __post_init__(self) -> None:
        n = len(self.macros)
        for name, shape in (("singular_values", (None,)), ("intervals", (n, 2)), ("covariance", (n, n))):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, frozen(value, float, shape, name=name))

    def by_member(self) -> dict[str, dict[int, tuple[float, float]]]:
        """Return the intervals by part and member number."""
        table: dict[str, dict[int, tuple[float, float]]] = {}
        for macro, (low, high) in zip(self.macros, self.intervals, strict=True):
            intervals = table.setdefault(macro.part.value, {})
            intervals.update(dict.fromkeys(macro.members, (float(low), float(high))))
        return table


def identify(
    parameterisation: Parameterisation,
    values: FloatArray,
    step: ParameterStep,
    remaining: FloatArray,
    errors: FloatArray | None,
    *,
    within: float,
) -> Identifiability:
    """Return the identifiability of coefficients near `values` by the data alone.

    The intervals are centred where one more step without prior would end, and as wide as the propagated
    errors: they hold for any number of wrong elements. They are those of relative changes, for loss
    factors of the changes themselves. Directions of the null space, or with a standard error above
    `within`, are rotated so that each has few coefficients. Kaiser (1958), Psychometrika 23, 187-200;
    van de Geer et al. (2014), Annals of Statistics 42, 1166-1202.

    Parameters
    ----------
    values
        (n_params,).
    step
        Least-squares step at `values`, with the pseudo-inverse of its equations.
    remaining, errors
        (n_rows,) residuals of the updated model, and the standard error of each row.
    """
    rates = log_derivatives(parameterisation, values)
    identifiable, null_space = _range_and_null_space(step, rates)
    is_hidden = (null_space**2).sum(axis=1) > IDENTIFIABILITY.null_share
    covariance = np.zeros((len(values), len(values)))
    if errors is not None:
        error_map = step.inverse / rates[:, None] * errors
        covariance = error_map @ error_map.T
    relative_errors = np.where(is_hidden, np.inf, np.sqrt(np.diag(covariance)))
    interval_errors = relative_errors if errors is not None else np.full(len(values), np.inf)
    weak_directions = _weak_directions(identifiable, covariance, within)
    directions = [
        *_directions(parameterisation, null_space, None),
        *_directions(parameterisation, weak_directions, covariance),
    ]
    unidentified = np.flatnonzero(relative_errors > within)
    return Identifiability(
        macros=parameterisation.macros,
        singular_values=step.singular_values,
        rank=step.rank,
        condition_number=step.condition_number,
        covariance=None if errors is None else covariance * np.outer(rates, rates),
        intervals=_intervals(parameterisation, values, step.inverse @ remaining / rates, interval_errors),
        unidentified=tuple(parameterisation.macros[i] for i in unidentified),
        directions=tuple(directions),
    )


def _range_and_null_space(step: ParameterStep, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return orthonormal relative changes within and beyond the rank, (n_params, n_params) in all."""
    n_params, n_rows = step.inverse.shape
    basis = np.linalg.svd(step.inverse, full_matrices=n_rows < n_params)[0]
    null_space = np.linalg.qr(basis[:, step.rank :] / rates[:, None])[0]
    full_basis = np.linalg.svd(null_space, full_matrices=True)[0] if null_space.size else np.eye(n_params)
    return full_basis[:, null_space.shape[1] :], null_space


def _intervals(
    parameterisation: Parameterisation, values: FloatArray, shift: FloatArray, relative_errors: FloatArray
) -> FloatArray:
    """Return 95 % confidence intervals (n_params, 2), clipped to the bounds."""
    lower, upper = parameterisation.bounds
    offsets = shift[:, None] + np.outer(
        relative_errors, [-IDENTIFIABILITY.normal_quantile, IDENTIFIABILITY.normal_quantile]
    )
    with np.errstate(over="ignore"):
        ends = np.where(
            parameterisation.damping[:, None], values[:, None] + offsets, values[:, None] * np.exp(offsets)
        )
    return np.clip(ends, lower[:, None], upper[:, None])


def _weak_directions(identifiable: FloatArray, covariance: FloatArray, within: float) -> FloatArray:
    """Return directions within the rank with too large a standard error, (n_params, k)."""
    variances, eigenvectors = np.linalg.eigh(identifiable.T @ covariance @ identifiable)
    return np.asarray((identifiable @ eigenvectors)[:, variances > within**2])


def _directions(
    parameterisation: Parameterisation, basis: FloatArray, covariance: FloatArray | None
) -> list[Direction]:
    directions = []
    for shares in _varimax(basis).T:
        indices = np.flatnonzero(np.abs(shares) >= IDENTIFIABILITY.named_share * np.abs(shares).max())
        indices = indices[np.argsort(-np.abs(shares[indices]), kind="stable")]
        macros = tuple(parameterisation.macros[i] for i in indices)
        error = None if covariance is None else float(np.sqrt(shares @ covariance @ shares))
        words = describe_ambiguity(macros, is_null=error is None)
        directions.append(Direction(macros, shares[indices] * np.sign(shares[indices[0]]), error, words))
    return sorted(
        directions,
        key=lambda direction: -np.inf if direction.standard_error is None else -direction.standard_error,
    )


def _varimax(directions: FloatArray) -> FloatArray:
    """Return a basis (n_params, k) of the same space with few large shares each, by varimax rotation."""
    n, k = directions.shape
    if k < 2:
        return directions
    rotation = np.eye(k)
    for _ in range(IDENTIFIABILITY.max_rotations):
        rotated = directions @ rotation
        u, _, vh = np.linalg.svd(directions.T @ (rotated**3 - rotated * (rotated**2).sum(axis=0) / n))
        next_rotation = u @ vh
        if np.abs(next_rotation - rotation).max() < IDENTIFIABILITY.null_share:
            break
        rotation = next_rotation
    return np.asarray(directions @ rotation)


def describe_ambiguity(macros: Iterable[MacroElement], *, is_null: bool) -> str:
    """Return a sentence, without full stop, on coefficients that the data do not determine."""
    listed_macros = tuple(macros)
    places: dict[str, list[str]] = {}
    for part in Part:
        if numbers := [number for macro in listed_macros if macro.part is part for number in macro.members]:
            places.setdefault("node " * part.is_nodal + _numbers(numbers), []).append(part.label)
    subject = " and ".join(f"{' and '.join(parts)} of {place}" for place, parts in places.items())
    if len(listed_macros) == 1:
        return (
            f"{subject} does not show in these data" if is_null else f"{subject} hardly shows in these data"
        )
    return f"{subject} {'cannot' if is_null else 'can hardly'} be told apart by these data"


def _numbers(numbers: Iterable[int]) -> str:
    """Return member numbers with runs of three and more abbreviated: 1, 4-7."""
    ordered = sorted(set(numbers))
    cuts = [0, *(i for i, (a, b) in enumerate(pairwise(ordered), 1) if b != a + 1), len(ordered)]
    runs = [ordered[start:stop] for start, stop in pairwise(cuts)]
    return ", ".join(
        f"{run[0]}-{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs if run
    )
