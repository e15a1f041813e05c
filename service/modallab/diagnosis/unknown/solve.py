"""Solution for an unknown effect: its place first, then its curve, then the model that the curve follows."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.diagnosis.fitting.fit import Fit
from modallab.diagnosis.optimisation.fit_parameters import ParameterVector
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.residual import residual
from modallab.diagnosis.result import CurvePoint, FittedParameter, Unknown, UnknownRival
from modallab.diagnosis.searching.search_path import SearchPath
from modallab.diagnosis.unknown.curve import SmoothCurve
from modallab.diagnosis.unknown.curve_model_choice import ChosenModel, choose_curve_model
from modallab.diagnosis.unknown.line_by_line import Influence, LineByLine, LineFit
from modallab.diagnosis.unknown.places import Influences, UnknownPlace
from modallab.diagnosis.unknown.settings import UNKNOWN
from modallab.rig.effect import Effect, is_nonlinear

OF_ROTATIONS = {"N/m": "N m/rad", "kg": "kg m^2", "N s/m": "N m s/rad"}
"""Units of models between rotations and moments, by those between translations and forces."""


@dataclass(frozen=True, eq=False)
class _Solution:
    """An unknown cause at one place, solved for at all lines."""

    place: UnknownPlace
    predictor: SingleTestPredictor
    """At the position of the nuisance parameters that fits best beside it."""
    accepted: tuple[Effect, ...]
    """Effects that act beside it, as fitted beside it."""
    influences: Influences
    lines: LineByLine
    found: LineFit
    gap: float
    """Sum of squares over the degrees of freedom."""


def unknown_effect(predictor: Predictor, path: SearchPath) -> Unknown | None:
    """Return the effect of no catalogue that closes most of a gap of the FRFs; None if none does.

    With one drive every line tells one internal force, and where two responses differ by it, the DoF at
    which it acts. It is solved for alone and beside the effects found; alone where that leaves no more, or
    where one of those is a nonlinear force: with that, no exact modification of rank one is known.

    Parameters
    ----------
    path
        The effects found, which leave a gap.
    """
    observed = predictor.observed
    if len(predictor.tests) > 1 or observed.n_simultaneous > 1 or observed.fitted.sum(axis=1).max() < 2:
        return None
    bases: list[tuple[tuple[Effect, ...], Fit]] = [((), path.start)]
    if path.steps and not is_nonlinear(path.fit.effects):
        bases.append((path.fit.effects, path.fit))
    solved = [_solve(predictor.tests[0], effects, start) for effects, start in bases]
    best, rivals = min(solved, key=lambda each: each[0].gap + UNKNOWN.cost_of_steps * len(each[0].accepted))
    most_left = 1 + UNKNOWN.closed_share * (path.fit.residual.gaps(observed.fitted)["frf"] - 1)
    if best.found.misfit / best.lines.n_data > most_left:  # no smooth curve leaves less
        return None
    result = _result(best, rivals, path.fit if best.accepted else path.start)
    return result if result.gap_after < most_left else None


def unknown_effect_at(predictor: SingleTestPredictor, start: Fit, place: UnknownPlace) -> Unknown:
    """Return the effect of no catalogue that closes most of a gap from a given place.

    Parameters
    ----------
    start
        Fit of the effects that act beside it.
    """
    near = predictor.with_nuisances_at(start.nuisance_position)
    return _result(_refine(near, start.effects, place), (), start)


def _solve(
    predictor: SingleTestPredictor, accepted: tuple[Effect, ...], start: Fit
) -> tuple[_Solution, tuple[UnknownPlace, ...]]:
    """Return the best solution beside some effects, and the places that cannot be distinguished from it."""
    near, costs, positions = predictor, dict[UnknownPlace, float](), dict[UnknownPlace, FloatArray]()
    # A missing effect distorts the fitted nuisance parameters: the declared ones may be nearer.
    for start_position in (start.starting_position, 0.0 * start.starting_position):
        near = predictor.with_nuisances_at(start_position)
        lines = LineByLine(near.coarse_prediction(accepted))
        influences = Influences(near, accepted, near.coarse_lines)
        for place in _nearest_places(lines, influences):
            found = lines.fit(influences.of(place))
            if found.chi_square < costs.get(place, np.inf):
                n = len(found.step) - len(start_position)
                costs[place], positions[place] = found.chi_square, start_position + found.step[n:]
    ranked = sorted(costs, key=lambda place: costs[place])

    def near_place(place: UnknownPlace) -> SingleTestPredictor:
        return predictor.with_nuisances_at(positions[place])

    first = _refine(near_place(ranked[0]), accepted, ranked[0])
    others = ranked[1 : UNKNOWN.refined_places]
    derivatives, least = first.lines.nuisances.derivatives, first.found.chi_square
    rivals = [_refine(near_place(place), accepted, place, derivatives, least) for place in others]
    solutions = [first, *rivals]
    best = min(solutions, key=lambda each: each.found.chi_square)
    if best is not first:
        least = best.found.chi_square
        best = _refine(best.predictor, best.accepted, best.place, derivatives, least)
    length = near.observed.correlation_length * max(1.0, best.gap)
    alike = [
        s.place for s in solutions if s.found.chi_square - best.found.chi_square < UNKNOWN.alike * length
    ]
    thinned = len(near.coarse_lines) / len(near.lines)
    least = costs[best.place] + UNKNOWN.alike * length * thinned
    alike += [place for place in ranked[UNKNOWN.refined_places :] if costs[place] < least]
    return best, tuple(place for place in alike if place != best.place)[: UNKNOWN.max_alike]


def _nearest_places(lines: LineByLine, influences: Influences) -> list[UnknownPlace]:
    """Return the places that a few steps bring nearest to the data, nearest first."""
    costs = {
        place: lines.fit(influences.of(place), max_steps=UNKNOWN.ranking_steps).chi_square
        for place in influences.places
    }
    return sorted(costs, key=lambda place: costs[place])[: UNKNOWN.fitted_places]


def _refine(
    predictor: SingleTestPredictor,
    accepted: tuple[Effect, ...],
    place: UnknownPlace,
    derivatives: FloatArray | None = None,
    least: float = np.inf,
) -> _Solution:
    """Return the solution for a cause at a place, at all lines, linearised anew where the last one ended.

    The derivatives by the nuisance parameters are kept: they leave out how these change the influence of the
    cause, so that steps with new ones gain no more.

    Parameters
    ----------
    derivatives
        (n_residuals, n) by the nuisance parameters; None: they are computed.
    least
        Sum of squares of another place: the refinement ends where this place cannot come near it.
    """
    last_square = np.inf
    for _ in range(UNKNOWN.refinements):
        solution = _solution_about(predictor, accepted, place, derivatives)
        step, square = solution.found.step, solution.found.chi_square
        gain, last_square = last_square - square, square
        if not np.abs(step).max(initial=0.0) > UNKNOWN.linear_step:
            break
        hopeless = square - UNKNOWN.remaining_gain * gain > least
        if hopeless or gain < UNKNOWN.refinement_gain * max(1.0, solution.gap):
            break
        derivatives = solution.lines.nuisances.derivatives
        parameters = ParameterVector(accepted)
        n = len(parameters)
        accepted = tuple(parameters.with_values(parameters.start + step[:n]))
        predictor = predictor.with_nuisances_at(predictor.position + step[n:])
    return solution


def _solution_about(
    predictor: SingleTestPredictor,
    accepted: tuple[Effect, ...],
    place: UnknownPlace,
    derivatives: FloatArray | None,
) -> _Solution:
    """Return the solution for a cause at a place, at all lines, about a position of the nuisances."""
    predict = predictor.linearisation_at(accepted)
    prediction = CoarsePrediction(predictor, accepted, predictor.observed, predict, derivatives)
    lines, influences = LineByLine(prediction), Influences(predictor, accepted, predictor.lines)
    found = lines.fit(influences.of(place))
    gap = found.misfit / max(lines.n_freedom, 1)
    return _Solution(place, predictor, accepted, influences, lines, found, gap)


def _result(solution: _Solution, rivals: Sequence[UnknownPlace], start: Fit) -> Unknown:
    place, observed = solution.place, solution.predictor.observed
    smooth = _smooth(solution)
    whole = 0.0 if isinstance(place.at, Dof) else 1.0
    model = _curve_model(solution, smooth)
    own = solution.influences.of(place)
    causes = [(own, smooth.at(observed.freq))] + ([] if model is None else [(model.influence, model.fit.z)])
    gap_after, held_out_gap_after = min(_gaps(solution, *cause) for cause in causes)
    held_out = observed.held_out_mask
    rotation = isinstance(place.at, Dof) and not place.at.translational
    return Unknown(
        cause=place.cause,
        at=place.at,
        curve=tuple(
            CurvePoint(float(f), float(value.real), float(value.imag), float(error))
            for f, value, error in zip(
                smooth.sites, smooth.at(smooth.sites) + whole, smooth.error, strict=True
            )
        ),
        unit="1" if whole else OF_ROTATIONS["N/m"] if rotation else "N/m",
        curve_model=None if model is None else model.fit.model.name,
        source=None if model is None else model.source,
        parameters={} if model is None else _parameters(model, rotation=rotation),
        gap_before=start.residual.gaps(observed.fitted)["frf"],
        gap_after=gap_after,
        held_out_gap_before=start.residual.gaps(held_out)["frf"] if held_out.any() else np.nan,
        held_out_gap_after=held_out_gap_after,
        beside_steps=bool(solution.accepted),
        rivals_alike=tuple(UnknownRival(rival.cause, rival.at) for rival in rivals),
    )


def _smooth(solution: _Solution) -> SmoothCurve:
    """Return the smooth curve through the values at the lines that tell them."""
    found, freq = solution.found, solution.predictor.observed.freq
    told = np.isfinite(found.error) & (freq > 0)
    return SmoothCurve.through(freq[told], found.z[told], found.error[told])


def _curve_model(solution: _Solution, smooth: SmoothCurve) -> ChosenModel | None:
    """Return the model of a solution; None if it follows none that is known."""
    lines, freq = solution.lines, solution.predictor.observed.freq
    influence = solution.influences.of(solution.place)
    left = lines.best_square(influence, smooth.at(freq))
    return choose_curve_model(
        lines,
        solution.influences,
        solution.place,
        solution.found.step,
        freq,
        (smooth, left),
        max(1.0, solution.gap),
    )


def _parameters(model: ChosenModel, *, rotation: bool) -> dict[str, FittedParameter]:
    """Return the parameters of a model in the units of a rotation where it acts on one."""
    if not rotation:
        return dict(model.fit.parameters)
    return {
        name: replace(p, unit=OF_ROTATIONS.get(p.unit, p.unit)) for name, p in model.fit.parameters.items()
    }


def _gaps(solution: _Solution, influence: Influence, z: ComplexArray) -> tuple[float, float]:
    """Return the gap of the fitted and of the held-out FRFs with a cause z (n_freq,)."""
    predictor, observed = solution.predictor, solution.predictor.observed
    predicted = predictor.predict(solution.accepted)
    left = residual(observed, replace(predicted, h=predicted.h * influence.ratio(z)))
    held_out = observed.held_out_mask
    return left.gaps(observed.fitted)["frf"], left.gaps(held_out)["frf"] if held_out.any() else np.nan
