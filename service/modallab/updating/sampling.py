"""Samples of the posterior of coefficients by an ensemble of Markov chains."""

from collections.abc import Callable
from typing import Any

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import MissingExtraError, UnderdeterminedError
from modallab.core.progress import Progress, silent
from modallab.updating.log_coefficients import from_log_changes, log_changes
from modallab.updating.modal_residuals import ModalResiduals
from modallab.updating.one_stage_path import OneStagePath
from modallab.updating.posterior import PosteriorSample
from modallab.updating.settings import ENSEMBLE


def require_sampler() -> Any:
    """Return emcee, the ensemble sampler.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    try:
        import emcee  # an optional dependency, only needed here
    except ImportError:
        raise MissingExtraError(
            "samples of a posterior need the extra `mcmc`",
            field="samples",
            value="emcee is not installed",
            allowed="pip install modallab[mcmc], or 0",
        ) from None
    return emcee


def sample(
    fit: ModalResiduals, stage_path: OneStagePath, n_draws: int, seed: int, progress: Progress = silent
) -> PosteriorSample:
    """Return draws from the posterior of coefficients, by the nonlinear model itself.

    Prior and block variances stay at the values of maximum evidence at which the update ended; coefficients
    that its prior eliminated stay at nominal. An ensemble of chains starts from the linearised posterior and
    moves by differences of its own members: Foreman-Mackey et al. (2013), PASP 125, 306-312; ter Braak and
    Vrugt (2008), Statistics and Computing 18, 435-446.

    Parameters
    ----------
    n_draws
        Least number of draws of all chains together.
    seed
        Of the random numbers: the same seed gives the same sample.

    Raises
    ------
    MissingExtraError
        If emcee is not installed.
    UnderdeterminedError
        If the prior leaves no coefficient free.
    """
    emcee = require_sampler()
    free = np.flatnonzero(stage_path.posterior.is_active)
    if not free.size:
        raise UnderdeterminedError(
            "the prior leaves no coefficient free: there is nothing to sample",
            field="samples",
            value=n_draws,
            allowed="the prior `common` or `range`",
        )
    log_density = _log_posterior(fit, stage_path, free)
    rng = np.random.default_rng(seed)
    n_chains = 2 * -(-max(ENSEMBLE.min_chains, int(ENSEMBLE.chains_per_coefficient * len(free))) // 2)
    initial_chains = _initial_chains(fit, stage_path, free, n_chains, rng)
    differential = ENSEMBLE.differential_move_fraction
    moves = [(emcee.moves.DEMove(), differential), (emcee.moves.DESnookerMove(), 1 - differential)]
    sampler = emcee.EnsembleSampler(n_chains, len(free), log_density, moves=moves)
    state = emcee.State(initial_chains, random_state=np.random.RandomState(rng.integers(2**32)).get_state())
    n_steps = -(-n_draws // n_chains)
    n_burn_in = int(ENSEMBLE.burn_in_fraction * n_steps) + 1
    for i, _ in enumerate(
        sampler.sample(state, iterations=n_burn_in + n_steps, skip_initial_state_check=True)
    ):
        progress((i + 1) / (n_burn_in + n_steps), f"draw {(i + 1) * n_chains}")
    chain = sampler.get_chain(discard=n_burn_in, flat=True)
    return PosteriorSample(
        macros=tuple(fit.parameterisation.macros[i] for i in free),
        draws=np.array([_coefficients(fit, free, point)[free] for point in chain]),
        log_density=sampler.get_log_prob(discard=n_burn_in, flat=True),
        acceptance=float(np.mean(sampler.acceptance_fraction)),
        autocorrelation_time=_autocorrelation_time(
            sampler.get_chain(discard=n_burn_in), emcee.autocorr.integrated_time
        ),
        n_chains=n_chains,
    )


def _coefficients(fit: ModalResiduals, free: IntArray, free_changes: FloatArray) -> FloatArray:
    """Return all coefficients (n_params,) for given log changes of the free ones (n_free,)."""
    all_changes = np.zeros(len(fit.parameterisation.macros))
    all_changes[free] = free_changes
    return from_log_changes(fit.parameterisation, all_changes)


def _change_bounds(fit: ModalResiduals, free: IntArray) -> tuple[FloatArray, FloatArray]:
    lower, upper = (log_changes(fit.parameterisation, bound)[free] for bound in fit.parameterisation.bounds)
    return lower, upper


def _log_posterior(
    fit: ModalResiduals, stage_path: OneStagePath, free: IntArray
) -> Callable[[FloatArray], float]:
    """Return a function: log posterior density of changes (n_free,), up to a constant."""
    posterior, weights, final = stage_path.posterior, stage_path.weights, stage_path.iterations.final
    # Errors are those of the data: the eigenvalues that balance the rows stay at their final values.
    unit = final.size * weights.units * np.sqrt(posterior.block_variances[weights.block])
    prior_variances = posterior.prior_variances[free]
    lower, upper = _change_bounds(fit, free)

    def density(point: FloatArray) -> float:
        if ((point < lower) | (point > upper)).any():
            return -np.inf
        try:
            state = fit.state(_coefficients(fit, free, point))
        except (UnderdeterminedError, np.linalg.LinAlgError):
            return -np.inf
        misfit = float(((state.difference / unit) ** 2).sum() + (point**2 / prior_variances).sum())
        return -misfit / 2 if np.isfinite(misfit) else -np.inf

    return density


def _initial_chains(
    fit: ModalResiduals, stage_path: OneStagePath, free: IntArray, n_chains: int, rng: np.random.Generator
) -> FloatArray:
    """Return initial points (n_chains, n_free): draws of the linearised posterior within the bounds."""
    posterior, final = stage_path.posterior, stage_path.iterations.final
    values, eigenvectors = np.linalg.eigh(posterior.covariance[np.ix_(free, free)])
    deviations = (
        rng.standard_normal((n_chains, len(free))) * np.sqrt(np.maximum(values, 0.0)) @ eigenvectors.T
    )
    points = posterior.mean[free] + deviations
    lower, upper = _change_bounds(fit, free)
    # Chains that start at the same point of a bound have no differences to move by.
    final_changes = log_changes(fit.parameterisation, final.values)[free]
    inner_points = final_changes + (np.clip(points, lower, upper) - final_changes) * rng.random(points.shape)
    return np.asarray(np.where((points < lower) | (points > upper), inner_points, points))


def _autocorrelation_time(chains: FloatArray, times: Any) -> FloatArray:
    """Return integrated autocorrelation times (n_free,) of chains (n_steps, n_chains, n_free).

    Where a chain never moved, the time is unknown and each chain counts as one draw.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        autocorrelation_times = np.asarray(times(chains, tol=0))
    return np.asarray(np.where(np.isfinite(autocorrelation_times), autocorrelation_times, float(len(chains))))
