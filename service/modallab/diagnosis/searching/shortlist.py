"""Shortlist of the suspects, places and values that are predicted one by one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.place import Channels, Dofs, Members
from modallab.core.progress import Progress
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import residual
from modallab.diagnosis.searching.modification_screen import ModificationScreen
from modallab.diagnosis.searching.robust_cost import RobustCost, line_minimum_fraction
from modallab.diagnosis.searching.scan_settings import LOSS, SCAN, SHORTLIST
from modallab.diagnosis.searching.starting_values import (
    near_minima,
    scan_sizes,
    smallest_amounts,
    with_amount_scaled,
)
from modallab.rig.effect import EFFECTS, Effect, Stage
from modallab.rig.frf_channel import FrfChannel


@dataclass(frozen=True)
class ListedPlace:
    """Values of an effect at a place that are predicted."""

    sizes: list[Effect]
    """The values."""
    refined: bool = False
    """Whether their amounts are the best ones of a finer grid."""


@dataclass(frozen=True)
class _ScreenedPlace:
    """Values of an effect at a place with their costs."""

    sizes: list[Effect]
    costs: FloatArray
    """(n_sizes, n_inflations)."""
    refined: bool = False
    """Whether amounts of a finer grid are among the values."""

    def best(self, inflation: int) -> Effect:
        """Return the value of least cost at a noise inflation."""
        return self.sizes[int(self.costs[:, inflation].argmin())]


@dataclass(frozen=True)
class _UnscreenedPlace:
    """Values of an effect at a place that has to be predicted."""

    sizes: list[Effect]
    linearised: FloatArray | None
    """(n_inflations,) costs of its equivalent linearisation; None if it has none."""


def shortlist(
    prediction: CoarsePrediction, accepted: Sequence[Effect], suspects: Sequence[Effect], progress: Progress
) -> list[ListedPlace]:
    """Return the values to predict, for each shortlisted suspect.

    Structural modifications at one of many places are screened in closed form, and the best places of each
    kind listed. Of effects on single channels those of the channels of the largest gap are listed.

    Parameters
    ----------
    suspects
        One effect for every kind and place.
    """
    predictor = prediction.predictor
    sample = prediction.subsampled(round(prediction.observed.fitted.sum() / SHORTLIST.sample_size))
    screen, cost = ModificationScreen(sample, accepted), RobustCost(sample)
    start = cost.project_out(screen.unmodified)
    worst = _worst_channels(prediction, accepted)
    observed = prediction.observed
    untested = {c for c, held_out in zip(observed.channels, observed.held_out, strict=True) if held_out}
    chosen: list[ListedPlace] = []
    screened: dict[str, list[_ScreenedPlace]] = {}
    unscreened: dict[str, list[_UnscreenedPlace]] = {}
    for i, suspect in enumerate(suspects):
        progress(i / len(suspects), f"places of {suspect.kind}")
        if _is_of_channels(suspect, observed) and not _concerns(suspect, worst, untested):
            continue
        sizes = scan_sizes(suspect, suspect.scan_values(predictor.system, predictor.setup))
        # Of an exciter's resonance many values compete, at a drive point too.
        located = isinstance(suspect.at, Dof | Dofs | Members) and suspect.stage is not Stage.DRIVE
        place = _screened(screen, sizes, cost, start) if located else None
        if place is not None:
            screened.setdefault(suspect.kind, []).append(place)
        elif located and isinstance(suspect.at, Dof):
            linearised = _linearised(screen, suspect, prediction.predictor, cost, start)
            unscreened.setdefault(suspect.kind, []).append(_UnscreenedPlace(sizes, linearised))
        else:
            chosen.append(ListedPlace(_likely_sizes(screen, sizes, cost)))
    for screened_places in screened.values():
        chosen += _best_screened(screen, screened_places, cost)
    for places in unscreened.values():
        likely = _likely(prediction, accepted, _likely_linearised(places, predictor))
        chosen += [ListedPlace(sizes) for sizes in likely]
    return chosen


def _linearised(
    screen: ModificationScreen, suspect: Effect, predictor: Predictor, cost: RobustCost, start: FloatArray
) -> FloatArray | None:
    """Return the least costs (n_inflations,) of the linear effects that one at a place may act like.

    None for an effect without equivalent linearisation.
    """
    effects = [EFFECTS[kind](at=suspect.at) for kind in suspect.linearised_kinds]
    choices = [
        scan_sizes(effect, effect.scan_values(predictor.system, predictor.setup)) for effect in effects
    ]
    screened = [place for sizes in choices if (place := _screened(screen, sizes, cost, start)) is not None]
    return np.vstack([place.costs for place in screened]).min(axis=0) if screened else None


def _likely_linearised(places: Sequence[_UnscreenedPlace], predictor: Predictor) -> list[list[Effect]]:
    """Return the measured places and, of the others, those whose equivalent linearisation costs least.

    All if there is no linearisation. Where a motion is measured the spectra tell a force too weak to change
    the FRFs.
    """
    if any(place.linearised is None for place in places):
        return [place.sizes for place in places]
    measured = {channel.response.point for channel in predictor.observed.channels}
    costs = np.array([place.linearised for place in places])
    best = np.unique(np.argsort(costs, axis=0)[: SHORTLIST.max_linearised_places])
    return [place.sizes for i, place in enumerate(places) if i in best or place.sizes[0].at in measured]


def _screened(
    screen: ModificationScreen, sizes: list[Effect], cost: RobustCost, start: FloatArray
) -> _ScreenedPlace | None:
    """Return the costs of values of an effect, and of one between none and the smallest.

    Parameters
    ----------
    start
        Residuals without the effect, nuisance parameters projected out.
    """
    vectors, unmodified = screen.residuals(sizes), screen.unmodified
    if vectors is None:
        return None
    # Where residuals are no larger than noise the best amount is below any of the grid.
    smallest = smallest_amounts(sizes)
    ends = cost.project_out(vectors[smallest])
    shares = [line_minimum_fraction(start, end) for end in ends]
    scaled = {i: share for i, share in zip(smallest, shares, strict=True) if share}
    scaled_vectors = [unmodified + share * (vectors[i] - unmodified) for i, share in scaled.items()]
    scaled_sizes = [with_amount_scaled(sizes[i], share) for i, share in scaled.items()]
    return _ScreenedPlace([*sizes, *scaled_sizes], cost.of(np.vstack([vectors, *scaled_vectors])))


def _best_screened(
    screen: ModificationScreen, places: Sequence[_ScreenedPlace], cost: RobustCost
) -> list[ListedPlace]:
    """Return the values of one kind to predict, with refined amounts at its likely places."""
    useful = SCAN.useful_cost * cost.of(screen.unmodified)
    likely = _of_least_cost(places, SHORTLIST.max_refined_places)
    return _best([_refined(screen, place, cost, useful) for place in likely], useful)


def _likely_sizes(screen: ModificationScreen, sizes: list[Effect], cost: RobustCost) -> list[Effect]:
    """Return the values about the local minima of the cost in closed form; all, if few or without such."""
    if len(sizes) <= SHORTLIST.max_sizes or (vectors := screen.residuals(sizes)) is None:
        return sizes
    costs = cost.of(vectors)
    chosen = {i for by_value in costs.T for i in near_minima(sizes, by_value)}
    return [sizes[i] for i in sorted(chosen)]


def _refined(
    screen: ModificationScreen, place: _ScreenedPlace, cost: RobustCost, useful: FloatArray
) -> _ScreenedPlace:
    """Return a screened place with more amounts, about the best one at each noise inflation.

    Where resonances shift by more than their bandwidths the right place, at an amount 50 % off, costs no less
    than other places.

    Parameters
    ----------
    useful
        (n_inflations,) costs above which a place does not improve the prediction.
    """
    for half_range, n in SHORTLIST.refinements:
        shares = np.exp(np.linspace(-half_range, half_range, n))
        centres: list[Effect] = []
        for w in np.flatnonzero(place.costs.min(axis=0) < useful):
            if (best := place.best(int(w))) not in centres and smallest_amounts([best]):
                centres.append(best)
        for centre in centres:  # one by one: many places have the same ones, and their stiffness is cached
            sizes = [with_amount_scaled(centre, float(share)) for share in shares]
            if (vectors := screen.residuals(sizes)) is not None:
                costs = np.vstack([place.costs, cost.of(vectors)])
                place = _ScreenedPlace([*place.sizes, *sizes], costs, refined=True)
    return place


def _of_least_cost(places: Sequence[_ScreenedPlace], n: int) -> list[_ScreenedPlace]:
    """Return the n places of least cost at each noise inflation."""
    costs = np.array([place.costs.min(axis=0) for place in places])
    return [places[i] for i in np.unique(np.argsort(costs, axis=0)[:n])]


def _best(places: Sequence[_ScreenedPlace], useful: FloatArray) -> list[ListedPlace]:
    """Return the values to predict at the best place of one kind, and at others that improve the prediction.

    Parameters
    ----------
    useful
        (n_inflations,) costs below which a place improves the prediction.
    """
    chosen: dict[int, list[Effect]] = {}
    for w, limit in enumerate(useful):
        lowest = [float(place.costs[:, w].min()) for place in places]
        order = sorted(range(len(places)), key=lambda i: lowest[i])
        for i in (order[0], *(i for i in order[1 : SHORTLIST.max_places] if lowest[i] < limit)):
            best = places[i].best(w)
            if best not in chosen.setdefault(i, []):
                chosen[i].append(best)
    return [ListedPlace(sizes, places[i].refined) for i, sizes in chosen.items()]


def _likely(
    prediction: CoarsePrediction, accepted: Sequence[Effect], places: list[list[Effect]]
) -> list[list[Effect]]:
    """Return the places of least cost for a few values of a kind, and for values between none and these.

    For nonlinear forces, whose prediction costs many times that of any other effect. One value would not
    do: a hundred times the true one explains nothing anywhere, and its linearisation misleads.
    """
    if len(places) <= SHORTLIST.max_nonlinear_places or len(places[0]) <= 2:
        return places
    observed, cost = prediction.observed, RobustCost(prediction)

    def vector(effects: Sequence[Effect]) -> FloatArray:
        return residual(observed, prediction.predict(effects)).vector(observed.fitted)

    unmodified = vector(accepted)
    start, costs = cost.project_out(unmodified), []
    for sizes in places:
        vectors = []
        for size in sizes[:: max(1, len(sizes) // SHORTLIST.nonlinear_sizes)]:
            modified = vector([*accepted, size])
            share = line_minimum_fraction(start, cost.project_out(modified))
            vectors += [modified, unmodified + share * (modified - unmodified)]
        costs.append(cost.of(np.array(vectors)).min(axis=0))
    order = np.argsort(costs, axis=0)[: SHORTLIST.max_nonlinear_places]
    return [places[i] for i in np.unique(order)]


def _is_of_channels(suspect: Effect, observed: Observed) -> bool:
    """Return whether an effect is of single channels: of responses, or of the force at one drive point."""
    if isinstance(suspect.at, Channels):
        return not {dof.point for dof in observed.outputs} <= set(suspect.at.points)
    return suspect.stage is Stage.CHANNEL and isinstance(suspect.at, Dof)


def _concerns(suspect: Effect, worst: set[FrfChannel], untested: set[FrfChannel]) -> bool:
    """Return whether an effect of single channels is of FRFs of a large gap.

    Of several responses each has to be one of them, or held out.
    """
    if not isinstance(suspect.at, Channels):
        return any(suspect.acts_on(channel.drive) for channel in worst)
    points = {channel.response.point for channel in worst}
    possible = points | {channel.response.point for channel in untested}
    places = set(suspect.at.points)
    return bool(places & points) and places <= possible


def _worst_channels(prediction: CoarsePrediction, accepted: Sequence[Effect]) -> set[FrfChannel]:
    """Return the FRFs of the largest gap at one of the noise inflations."""
    observed, predicted = prediction.observed, prediction.predict(accepted)
    scale = LOSS.cauchy_scale
    worst: set[FrfChannel] = set()
    for noise_inflation in LOSS.noise_inflations:
        inflated = residual(observed, predicted, noise_inflation=noise_inflation)
        squares = [
            np.abs(inflated.frf) ** 2,
            *([] if inflated.response is None else [inflated.response**2]),
        ]
        losses = [scale * np.log1p(square / scale) * observed.fitted for square in squares]
        order = np.argsort(-np.sum(losses, axis=(0, 1)))
        worst |= {observed.channels[i] for i in order[: SHORTLIST.max_channels]}
    return worst
