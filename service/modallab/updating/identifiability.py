"""What measured modes can say about coefficients, and what they cannot, in words."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from modallab.core.arrays import FloatArray, frozen
from modallab.updating.log_coefficients import slopes
from modallab.updating.parameterisation import MacroElement, Parameterisation, Part
from modallab.updating.solve import ParameterStep

NORMAL_95 = 1.959964  # standard errors to either side that hold 95 % of a normal distribution
HIDDEN = 1e-6  # share of a coefficient beyond the rank that is more than rounding
NAMED = 0.25  # of the largest share of a direction: smaller ones are not named
TURNS = 50  # of directions towards few coefficients each


@dataclass(frozen=True, eq=False)
class Direction:
    """Coefficients that may change together, in these proportions, and data show little or nothing of it."""

    macros: tuple[MacroElement, ...]
    shares: FloatArray  # (n_macros,) relative changes, their squares one in all
    standard_error: float | None  # of the relative change along it; None where data say nothing at all
    words: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "shares", frozen(self.shares, float, (len(self.macros),), name="shares"))


@dataclass(frozen=True, eq=False)
class Identifiability:
    """How far data alone determine coefficients, whatever was held likely of them before."""

    macros: tuple[MacroElement, ...]  # (n_params,) what each coefficient multiplies
    singular_values: FloatArray  # of the equations whose rank is told, falling
    rank: int
    condition_number: float
    # (n_params, n_params) of the coefficients, by the errors of the data; beyond the rank nothing is in it.
    # None where there is nothing to judge errors by.
    covariance: FloatArray | None
    intervals: FloatArray  # (n_params, 2) that hold a coefficient with 95 %, within its bounds
    unidentified: tuple[MacroElement, ...]  # whose intervals are wider than `identified_within` admits
    directions: tuple[Direction, ...]

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
            own = table.setdefault(macro.part.value, {})
            own.update(dict.fromkeys(macro.members, (float(low), float(high))))
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
    """Return what data alone say of coefficients near `values`.

    The intervals are about where one more step without any prior would end, and as wide as the errors
    carried through it: they hold for any number of wrong elements. Relative changes are judged, of loss
    factors the changes themselves. What lies beyond the rank, or has a standard error of more than
    `within`, is told as directions turned so that each holds few coefficients. Kaiser (1958),
    Psychometrika 23, 187-200; van de Geer et al. (2014), Annals of Statistics 42, 1166-1202.

    Parameters
    ----------
    values
        (n_params,).
    step
        Of the equations at `values`; its inverse maps rows to coefficients.
    remaining, errors
        (n_rows,) what the updated model misses, and the standard error of each row.
    """
    rates = slopes(parameterisation, values)
    seen, beyond = _split(step, rates)
    hidden = (beyond**2).sum(axis=1) > HIDDEN
    relative = np.zeros((len(values), len(values)))
    if errors is not None:
        carried = step.inverse / rates[:, None] * errors
        relative = carried @ carried.T
    spread = np.where(hidden, np.inf, np.sqrt(np.diag(relative)))
    wide = spread if errors is not None else np.full(len(values), np.inf)
    weak = _weak(seen, relative, within)
    pairs = [*_told(parameterisation, beyond, None), *_told(parameterisation, weak, relative)]
    vague = np.flatnonzero(spread > within)
    return Identifiability(
        macros=parameterisation.macros,
        singular_values=step.singular_values,
        rank=step.rank,
        condition_number=step.condition_number,
        covariance=None if errors is None else relative * np.outer(rates, rates),
        intervals=_intervals(parameterisation, values, step.inverse @ remaining / rates, wide),
        unidentified=tuple(parameterisation.macros[i] for i in vague),
        directions=tuple(pairs),
    )


def _split(step: ParameterStep, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return orthonormal relative changes within and beyond the rank, (n_params, n_params) in all."""
    n_params, n_rows = step.inverse.shape
    basis = np.linalg.svd(step.inverse, full_matrices=n_rows < n_params)[0]
    beyond = np.linalg.qr(basis[:, step.rank :] / rates[:, None])[0]
    both = np.linalg.svd(beyond, full_matrices=True)[0] if beyond.size else np.eye(n_params)
    return both[:, beyond.shape[1] :], beyond


def _intervals(
    parameterisation: Parameterisation, values: FloatArray, shift: FloatArray, spread: FloatArray
) -> FloatArray:
    """Return (n_params, 2); beyond its bounds nothing is held likely of a coefficient."""
    lower, upper = parameterisation.bounds
    away = shift[:, None] + np.outer(spread, [-NORMAL_95, NORMAL_95])
    with np.errstate(over="ignore"):
        ends = np.where(
            parameterisation.damping[:, None], values[:, None] + away, values[:, None] * np.exp(away)
        )
    return np.clip(ends, lower[:, None], upper[:, None])


def _weak(seen: FloatArray, relative: FloatArray, within: float) -> FloatArray:
    """Return (n_params, k) directions within the rank along which the standard error is too large."""
    variances, turn = np.linalg.eigh(seen.T @ relative @ seen)
    return np.asarray((seen @ turn)[:, variances > within**2])


def _told(
    parameterisation: Parameterisation, directions: FloatArray, relative: FloatArray | None
) -> list[Direction]:
    told = []
    for shares in _turned_to_few(directions).T:
        named = np.flatnonzero(np.abs(shares) >= NAMED * np.abs(shares).max())
        named = named[np.argsort(-np.abs(shares[named]), kind="stable")]
        macros = tuple(parameterisation.macros[i] for i in named)
        error = None if relative is None else float(np.sqrt(shares @ relative @ shares))
        words = in_words(macros, unseen=error is None)
        told.append(Direction(macros, shares[named] * np.sign(shares[named[0]]), error, words))
    return sorted(told, key=lambda one: -np.inf if one.standard_error is None else -one.standard_error)


def _turned_to_few(directions: FloatArray) -> FloatArray:
    """Return orthonormal directions (n_params, k) of the same space, each with few large shares: varimax."""
    n, k = directions.shape
    if k < 2:
        return directions
    turn = np.eye(k)
    for _ in range(TURNS):
        now = directions @ turn
        u, _, vh = np.linalg.svd(directions.T @ (now**3 - now * (now**2).sum(axis=0) / n))
        after = u @ vh
        if np.abs(after - turn).max() < HIDDEN:
            break
        turn = after
    return np.asarray(directions @ turn)


def in_words(macros: Iterable[MacroElement], *, unseen: bool) -> str:
    """Return what data cannot say about these coefficients, as a sentence without its full stop."""
    named = tuple(macros)
    places: dict[str, list[str]] = {}
    for part in Part:
        if numbers := [number for macro in named if macro.part is part for number in macro.members]:
            places.setdefault("node " * part.at_node + _numbers(numbers), []).append(part.words)
    what = " and ".join(f"{' and '.join(parts)} of {where}" for where, parts in places.items())
    if len(named) == 1:
        return f"{what} does not show in these data" if unseen else f"{what} hardly shows in these data"
    return f"{what} {'cannot' if unseen else 'can hardly'} be told apart by these data"


def _numbers(numbers: Iterable[int]) -> str:
    """Return member numbers with runs of three and more in short: 1, 4-7."""
    ordered = sorted(set(numbers))
    cuts = [0, *(i for i, (a, b) in enumerate(pairwise(ordered), 1) if b != a + 1), len(ordered)]
    runs = [ordered[start:stop] for start, stop in pairwise(cuts)]
    return ", ".join(
        f"{run[0]}-{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs if run
    )
