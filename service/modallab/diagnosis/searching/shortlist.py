"""Which suspects, at which places and in which sizes, deserve a prediction of their own."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.place import Channels, Members
from modallab.core.progress import Progress
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.residuals.residual import residual
from modallab.diagnosis.searching.modification_screen import ModificationScreen
from modallab.diagnosis.searching.robust_cost import (
    HEAVY_TAIL,
    NOISE_INFLATIONS,
    Costs,
    line_minimum_fraction,
)
from modallab.diagnosis.searching.starting_values import scan_sizes, smallest_amounts, with_amount_scaled
from modallab.rig.effect import Effect

PLACES = 4  # of a kind that go on, for each widening
ENOUGH = 1500  # numbers of FRFs, of all channels, that places are told apart by
ROUGHLY = 2  # places of a nonlinear force that go on, for each widening
SIZES = 5  # of it, or a few more, that its places are told apart by
CHANNELS = 3  # that disagree most and may be at fault, for each widening


@dataclass(frozen=True)
class _Look:
    """Sizes of an effect at a place, with what each leaves at every widening (n_sizes, n_widenings)."""

    sizes: list[Effect]
    costs: FloatArray

    def best(self, widening: int) -> Effect:
        return self.sizes[int(self.costs[:, widening].argmin())]


def shortlist(
    glimpses: CoarsePrediction, accepted: Sequence[Effect], suspects: Sequence[Effect], progress: Progress
) -> list[list[Effect]]:
    """Return for each suspect that is worth it the sizes to predict.

    What hangs on the structure at one of many places is foreseen in closed form, and the best places of
    each kind go on. Of what acts on single channels those go on that disagree.

    Parameters
    ----------
    suspects
        One effect for every kind and place.
    """
    predictor = glimpses.predictor
    sample = glimpses.subsampled(round(glimpses.observed.fitted.sum() / ENOUGH))
    foreseen, costs = ModificationScreen(sample, accepted), Costs(sample)
    start = costs.project_out(foreseen.unmodified)
    worst = _worst_channels(glimpses, accepted)
    chosen: list[list[Effect]] = []
    looks: dict[str, list[_Look]] = {}
    unforeseen: dict[str, list[list[Effect]]] = {}
    for i, suspect in enumerate(suspects):
        progress(i / len(suspects), f"places of {suspect.kind}")
        if isinstance(suspect.at, Channels) and not any(suspect.acts_on(dof) for dof in worst):
            continue
        sizes = scan_sizes(suspect, suspect.scan_values(predictor.system, predictor.setup))
        look = _foreseen(foreseen, sizes, costs, start) if isinstance(suspect.at, Dof | Members) else None
        if look is not None:
            looks.setdefault(suspect.kind, []).append(look)
        elif isinstance(suspect.at, Dof):
            unforeseen.setdefault(suspect.kind, []).append(sizes)
        else:
            chosen.append(sizes)
    for places in looks.values():
        chosen += _best(places)
    for at_places in unforeseen.values():
        chosen += _likely(glimpses, accepted, at_places)
    return chosen


def _foreseen(
    foreseen: ModificationScreen, sizes: list[Effect], costs: Costs, start: FloatArray
) -> _Look | None:
    """Return what sizes of an effect leave, one more between nothing and the smallest included.

    Parameters
    ----------
    start
        Residuals without any, less what tolerances explain.
    """
    ratios = foreseen.ratios(sizes)
    if ratios is None:
        return None
    vectors, nothing = foreseen.vectors(ratios), foreseen.unmodified
    # Where residuals are no larger than noise the best size is smaller than any that is tried.
    smallest = smallest_amounts(sizes)
    moved = costs.project_out(vectors[smallest])
    shares = [line_minimum_fraction(start, one) for one in moved]
    between = {i: share for i, share in zip(smallest, shares, strict=True) if share}
    along = [nothing + share * (vectors[i] - nothing) for i, share in between.items()]
    smaller = [with_amount_scaled(sizes[i], share) for i, share in between.items()]
    return _Look([*sizes, *smaller], costs.of(np.vstack([vectors, *along])))


def _best(places: Sequence[_Look]) -> list[list[Effect]]:
    """Return the sizes worth a prediction at the best places of one kind."""
    chosen: dict[int, list[Effect]] = {}
    for w in range(len(NOISE_INFLATIONS)):
        for i in sorted(range(len(places)), key=lambda i: float(places[i].costs[:, w].min()))[:PLACES]:
            best = places[i].best(w)
            if best not in chosen.setdefault(i, []):
                chosen[i].append(best)
    return list(chosen.values())


def _likely(
    glimpses: CoarsePrediction, accepted: Sequence[Effect], places: list[list[Effect]]
) -> list[list[Effect]]:
    """Return the places where a few sizes of a kind, or more or less of each in a straight line, leave least.

    Nonlinear forces: a prediction of each costs many times that of anything else. One size would not do:
    a hundred times what is there it explains nothing anywhere, and its straight line misleads.
    """
    if len(places) <= ROUGHLY or len(places[0]) <= 2:
        return places
    observed, costs = glimpses.observed, Costs(glimpses)

    def left(effects: Sequence[Effect]) -> FloatArray:
        return residual(observed, glimpses.predict(effects)).vector(observed.fitted)

    nothing = left(accepted)
    start, leaves = costs.project_out(nothing), []
    for sizes in places:
        looks = []
        for size in sizes[:: max(1, len(sizes) // SIZES)]:
            moved = left([*accepted, size])
            looks += [
                moved,
                nothing + line_minimum_fraction(start, costs.project_out(moved)) * (moved - nothing),
            ]
        leaves.append(costs.of(np.array(looks)).min(axis=0))
    order = np.argsort(leaves, axis=0)[:ROUGHLY]
    return [places[i] for i in np.unique(order)]


def _worst_channels(glimpses: CoarsePrediction, accepted: Sequence[Effect]) -> set[Dof]:
    """Return the responses that disagree most at one of the widenings."""
    observed, predicted = glimpses.observed, glimpses.predict(accepted)
    worst: set[Dof] = set()
    for widen in NOISE_INFLATIONS:
        left = residual(observed, predicted, noise_inflation=widen)
        squares = [np.abs(left.frf) ** 2, *([] if left.response is None else [left.response**2])]
        each = [HEAVY_TAIL * np.log1p(one / HEAVY_TAIL) * observed.fitted for one in squares]
        order = np.argsort(-np.sum(each, axis=(0, 1)))
        worst |= {observed.outputs[i] for i in order[:CHANNELS]}
    return worst
