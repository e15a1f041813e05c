"""Fits of the parameters of effects to expected spectra, with errors and bounds.

Every fit also estimates the nuisance parameters under their prior; see `nuisances`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import FloatArray
from modallab.core.numerics import SAFE_SQUARED_DIVISOR
from modallab.diagnosis.fitting.covariance import ParameterErrors, standard_errors
from modallab.diagnosis.fitting.fit_task import FitTask, minimised
from modallab.diagnosis.fitting.held_out_nuisances import fit_held_out_nuisances
from modallab.diagnosis.fitting.settings import FIT
from modallab.diagnosis.optimisation.fit_parameters import ParameterVector
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.residual import Residual, error_ratio
from modallab.rig.effect import Effect
from modallab.rig.spectrum_settings import SIMULATED_VARIANCE


@dataclass(frozen=True, eq=False)
class Fit:
    """Effects with fitted parameters, and their residual."""

    effects: tuple[Effect, ...]
    """Effects with the fitted values."""
    residual: Residual
    """Residual of the prediction with them."""
    chi_square: float
    """Sum of squares of the fitted residuals and of the nuisance parameters' prior."""
    n_parameters: int
    """Parameters of the effects that change a prediction; nuisance parameters are the same in every fit."""
    n_data: int
    """Fitted residuals."""
    correlation_length: float
    """Data per independent datum."""
    compute_errors: Callable[[], ParameterErrors]
    """Computes the standard errors."""
    n_placements: float = 1.0
    """Number of ways to place the local effects: the product of the numbers of places of their kinds."""
    n_possible_placements: float = 1.0
    """Number of ways to place all effects, if global ones were local too."""
    nuisance_position: FloatArray = field(default_factory=lambda: np.zeros(0))
    """(n,) of the nuisance parameters, standard deviations."""
    starting_position: FloatArray = field(default_factory=lambda: np.zeros(0))
    """(n,) to search from: as far as an effect is missing, drawn back to the declared values."""
    nuisance_derivatives: NDArray[np.float32] | None = None
    """(n_data, n) of residuals by the fitted nuisance parameters without effects; None if not known."""

    @cached_property
    def _errors(self) -> ParameterErrors:
        return self.compute_errors()

    @property
    def errors(self) -> tuple[dict[str, float], ...]:
        """Standard errors of the parameters of each effect; computed on demand, as few fits need them."""
        return self._errors.effects

    @property
    def nuisance_errors(self) -> FloatArray:
        """(n,) standard errors of `nuisance_position`, standard deviations."""
        return np.sqrt(np.diag(self.nuisance_covariance))

    @property
    def nuisance_covariance(self) -> FloatArray:
        """(n, n) covariance of `nuisance_position`, in standard deviations of the prior."""
        return self._errors.nuisance_covariance

    @property
    def prediction_variance(self) -> Mapping[str, float]:
        """Mean variance of held-out residuals by errors of fitted parameters, over that of noise, by part."""
        return self._errors.prediction_variance

    @property
    def bic(self) -> float:
        """Extended Bayesian information criterion, times the data's correlation length; lower is better."""
        return self.chi_square + self.penalty

    def bic_between_kinds(self, overdispersion: float = 1.0) -> float:
        """Return the BIC for a comparison of kinds of effects, with `penalty_between_kinds`.

        Parameters
        ----------
        overdispersion
            Variance of the residuals over that of the random error.
        """
        return self.chi_square / overdispersion + self.penalty_between_kinds

    @property
    def penalty(self) -> float:
        """Penalty of the extended BIC: for the number of parameters, and for the choice of places.

        The best of many places fits better by chance. A global effect has the same prior probability as all
        places of its kind together. Chen and Chen, Biometrika 95 (2008), 759, with gamma = 1.
        """
        return self.n_parameters * self.cost_per_parameter + self._choice_penalty(self.n_placements)

    @property
    def is_near_data(self) -> bool:
        """Whether residuals are little more than random error, so that further parameters act linearly."""
        return self.chi_square < FIT.near_noise * self.n_data

    @property
    def penalty_between_kinds(self) -> float:
        """Penalty for a comparison of kinds of effects: every place of every kind is equally probable."""
        return self.penalty - self._choice_penalty(self.n_possible_placements)

    def _choice_penalty(self, n_placements: float) -> float:
        return 2 * self.correlation_length * float(np.log(n_placements))

    @property
    def cost_per_parameter(self) -> float:
        """Penalty of the BIC for one parameter."""
        independent = max(self.n_data / self.correlation_length, 2)
        return self.correlation_length * float(np.log(independent))


def fit(
    predictor: Predictor,
    effects: Sequence[Effect],
    *,
    fixed: Sequence[Effect] = (),
    near: Fit | None = None,
    max_chi_square: float = np.inf,
    approach: bool = False,
    largest_ratio: float = np.inf,
) -> Fit:
    """Return the effects with all their parameters fitted together, from starts near the solution.

    Bounded least squares on logarithmic ratios. Random errors of distortion in bursts are those of the
    start: where an effect near the data ends far from it, they are renewed and it is fitted once more.

    Parameters
    ----------
    fixed
        Effects that act but are not fitted.
    near
        Fit of the same data whose derivatives by nuisance parameters the first steps take.
    max_chi_square
        Chi-square of use: a fit that a few steps without new derivatives leave above it is given up.
    approach
        Whether every random error is inflated first, for a start far from the data.
    largest_ratio
        Largest ratio by which positive parameters of intermittent effects may change. If it is finite, the
        random errors of the start are kept.
    """
    fit_from = partial(_fit, predictor, approach=approach, largest_ratio=largest_ratio)
    found = fit_from(effects, fixed, near, max_chi_square)
    bursts = any(effect.intermittent for effect in effects) and not np.isfinite(largest_ratio)
    if bursts and found.is_near_data and _differ(effects, found.effects):
        return fit_from(found.effects, fixed, near, max_chi_square)
    return found


def chi_square_with_own_errors(predictor: Predictor, effects: Sequence[Effect]) -> float:
    """Return chi-square of effects as they are, with the random errors that distortion of their size has.

    The nuisance parameters are the predictor's; nothing is fitted.
    """
    plain, predictor = predictor, predictor.with_intermittent_errors(effects)
    vector = predictor.residual(effects).vector(predictor.observed.fitted)
    prior = predictor.observed.correlation_length * float(predictor.position @ predictor.position)
    return float(vector @ vector) + prior + _normalisation(plain, predictor)


def _normalisation(plain: Predictor, wide: Predictor) -> float:
    """Return what wider random errors add to chi-square: they pay for the residuals that they forgive."""
    return -2 * float(np.log(error_ratio(plain.observed, wide.observed)).sum())


def with_optional_parameters(predictor: Predictor, candidate: Fit, near: Fit) -> Fit:
    """Return a fit with the optional parameters and other choices of its last effect, if BIC is lower.

    Parameters
    ----------
    near
        As in `fit`.
    """
    if not candidate.effects:
        return candidate
    *others, effect = candidate.effects
    variants = (fit(predictor, (*others, each), near=near) for each in effect.variants(predictor.system))
    return min((candidate, *variants), key=lambda found: found.bic)


def _differ(start: Sequence[Effect], final: Sequence[Effect]) -> bool:
    """Return whether effects in bursts have other parameters, far enough for other random errors."""
    pairs = [
        (value, one.parameters[name])
        for one, other in zip(start, final, strict=True)
        if one.intermittent
        for name, value in other.parameters.items()
    ]
    ratio = 2 ** (1 / SIMULATED_VARIANCE.values_per_octave)
    return any(not low / ratio < high < low * ratio for low, high in pairs)


def _fit(
    predictor: Predictor,
    effects: Sequence[Effect],
    fixed: Sequence[Effect],
    near: Fit | None,
    max_chi_square: float,
    *,
    approach: bool,
    largest_ratio: float,
) -> Fit:
    """Return `fit` with the random errors of the start."""
    plain, predictor = predictor, predictor.with_intermittent_errors([*fixed, *effects])
    near_derivatives = None if near is None else near.nuisance_derivatives
    # Those of a fit with effects are of the one before it.
    keep_derivatives = near is not None and not near.effects and near.is_near_data
    known = near_derivatives
    if known is not None and predictor.observed is not plain.observed:
        ratio = error_ratio(plain.observed, predictor.observed).astype(np.float32)
        known = ratio[:, None] * known if keep_derivatives else None
    parameters = ParameterVector(effects, largest_ratio)
    task = FitTask(predictor, fixed, parameters, known, keep_derivatives=keep_derivatives)
    start, derivatives = minimised(task, max_chi_square, approach=approach)
    fitted_residual, final, position = task.residuals[start.tobytes()], *task.at(start)
    observed = predictor.observed
    vector = fitted_residual.vector(observed.fitted)
    square = float(vector @ vector)
    chi_square = square + observed.correlation_length * float(position @ position)
    starting_position = position.copy()
    starting_position[task.free] += _prior_step(
        derivatives / np.sqrt(_missing_effect_variance(square, len(vector), observed.correlation_length)),
        position[task.free],
    )
    predictor = predictor.with_nuisances_at(position)
    if len(task.held_out):
        position = fit_held_out_nuisances(predictor, [*fixed, *final], fitted_residual, task.held_out)
        predictor = predictor.with_nuisances_at(position)
        fitted_residual = predictor.residual([*fixed, *final])
    compute_errors = partial(standard_errors, predictor, tuple(fixed), tuple(final), fitted_residual)
    if predictor.observed is not plain.observed:
        chi_square += _normalisation(plain, predictor)
        fitted_residual = plain.with_nuisances_at(position).residual([*fixed, *final])
    return Fit(
        tuple(final),
        fitted_residual,
        chi_square,
        int(derivatives[:, : len(task.parameters)].any(axis=0).sum()),
        len(vector),
        plain.observed.correlation_length,
        compute_errors,
        *_placements(plain, [*fixed, *final]),
        position,
        starting_position,
        near_derivatives if effects or fixed else derivatives.astype(np.float32),
    )


def _placements(predictor: Predictor, effects: Sequence[Effect]) -> tuple[float, float]:
    """Return `Fit.n_placements` and `Fit.n_possible_placements`."""
    system, setup = predictor.system, predictor.setup
    kinds = {type(effect) for effect in effects}
    n_places = {kind: max(1, sum(at is not None for at in kind.places(system, setup))) for kind in kinds}
    local = [n_places[type(effect)] for effect in effects if effect.at is not None]
    return float(np.prod(local)), float(np.prod([n_places[type(effect)] for effect in effects]))


def _missing_effect_variance(square: float, n_data: int, correlation_length: float) -> float:
    """Return the variance of a residual where an effect may be missing.

    The mean square of the residuals, where it is above the random error; and beyond that the square of a
    missing effect, which amounts to a few independent data.
    """
    scale = correlation_length * max(1.0, square / n_data)
    return scale + correlation_length * max(0.0, square - n_data) / FIT.missing_effect_data


def _prior_step(derivatives: FloatArray, position: FloatArray) -> FloatArray:
    """Return the step (n,) from the best fit of the data to that of data and prior.

    Parameters
    ----------
    derivatives
        (n_data, n_parameters) of residuals of unit variance.
    position
        (n,) of the last parameters, which have a prior of unit variance about 0.
    """
    if not len(position):
        return position
    n_parameters, n = derivatives.shape[1], len(position)
    prior, gradient = np.zeros(n_parameters), np.zeros(n_parameters)
    prior[n_parameters - n :] = 1.0
    gradient[n_parameters - n :] = position
    size = np.sqrt((derivatives**2).sum(axis=0) + prior) + SAFE_SQUARED_DIVISOR
    curvature = (derivatives.T @ derivatives + np.diag(prior)) / np.outer(size, size)
    step: FloatArray = -np.linalg.pinv(curvature) @ (gradient / size) / size
    return step[n_parameters - n :]
