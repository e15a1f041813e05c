"""What data and prior say of coefficients, without a straight line between: a sample of the posterior."""

from collections.abc import Callable
from typing import Any

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import MissingExtraError, UnderdeterminedError
from modallab.core.progress import Progress, silent
from modallab.updating.log_coefficients import changed, changes
from modallab.updating.modal_residuals import ModalResiduals
from modallab.updating.one_stage_path import OneStagePath
from modallab.updating.posterior import PosteriorSample

FEWEST_WALKERS = 16
WALKERS = 2.5  # a coefficient: the ensemble needs more than two to span all directions
SETTLING = 0.25  # of the draws that are kept, so many are made before: the start is a straight line's


def require_sampler() -> Any:
    """Return emcee, the ensemble sampler.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    try:
        import emcee  # an extra: nothing else of the product needs it
    except ImportError:
        raise MissingExtraError(
            "samples of a posterior need the extra `mcmc`",
            field="samples",
            value="emcee is not installed",
            allowed="pip install modallab[mcmc], or 0",
        ) from None
    return emcee


def sample(
    fit: ModalResiduals, whole: OneStagePath, n_draws: int, seed: int, progress: Progress = silent
) -> PosteriorSample:
    """Return draws from the posterior of an update's coefficients by the model itself, not made linear.

    Prior widths and errors of the data are those of most evidence that the update ended with; coefficients
    that its prior left out stay at no change. An ensemble of chains starts from the linearised posterior and
    moves by differences of its own members: Foreman-Mackey et al. (2013), PASP 125, 306-312; ter Braak and
    Vrugt (2008), Statistics and Computing 18, 435-446.

    Parameters
    ----------
    n_draws
        At least so many are kept, of all chains together.
    seed
        Of the draws: the same seed, the same sample.

    Raises
    ------
    MissingExtraError
        If emcee is not installed.
    UnderdeterminedError
        If the prior leaves no coefficient free.
    """
    emcee = require_sampler()
    free = np.flatnonzero(whole.belief.kept)
    if not free.size:
        raise UnderdeterminedError(
            "the prior leaves no coefficient free: there is nothing to sample",
            field="samples",
            value=n_draws,
            allowed="the prior `common` or `range`",
        )
    density = _density(fit, whole, free)
    rng = np.random.default_rng(seed)
    n_chains = 2 * -(-max(FEWEST_WALKERS, int(WALKERS * len(free))) // 2)
    begin = _start(fit, whole, free, n_chains, rng)
    mixed = [(emcee.moves.DEMove(), 0.8), (emcee.moves.DESnookerMove(), 0.2)]
    sampler = emcee.EnsembleSampler(n_chains, len(free), density, moves=mixed)
    state = emcee.State(begin, random_state=np.random.RandomState(rng.integers(2**32)).get_state())
    kept = -(-n_draws // n_chains)
    settling = int(SETTLING * kept) + 1
    for i, _ in enumerate(sampler.sample(state, iterations=settling + kept, skip_initial_state_check=True)):
        progress((i + 1) / (settling + kept), f"draw {(i + 1) * n_chains}")
    drawn = sampler.get_chain(discard=settling, flat=True)
    return PosteriorSample(
        macros=tuple(fit.parameterisation.macros[i] for i in free),
        draws=np.array([_coefficients(fit, free, one)[free] for one in drawn]),
        log_density=sampler.get_log_prob(discard=settling, flat=True),
        acceptance=float(np.mean(sampler.acceptance_fraction)),
        correlation=_correlation(sampler.get_chain(discard=settling), emcee.autocorr.integrated_time),
        n_chains=n_chains,
    )


def _coefficients(fit: ModalResiduals, free: IntArray, own: FloatArray) -> FloatArray:
    """Return coefficients (n_params,) from the changes (n_free,) of those that are free."""
    every = np.zeros(len(fit.parameterisation.macros))
    every[free] = own
    return changed(fit.parameterisation, every)


def _limits(fit: ModalResiduals, free: IntArray) -> tuple[FloatArray, FloatArray]:
    lower, upper = (changes(fit.parameterisation, bound)[free] for bound in fit.parameterisation.bounds)
    return lower, upper


def _density(fit: ModalResiduals, whole: OneStagePath, free: IntArray) -> Callable[[FloatArray], float]:
    """Return the logarithm of the posterior of changes (n_free,), up to a constant."""
    belief, weights, final = whole.belief, whole.weights, whole.path.final
    # Errors are those of the data: what the model's own eigenvalues balance them by stays where it ended.
    unit = final.size * weights.units * np.sqrt(belief.scales[weights.block])
    widths = belief.widths[free]
    lower, upper = _limits(fit, free)

    def density(own: FloatArray) -> float:
        if ((own < lower) | (own > upper)).any():
            return -np.inf
        try:
            state = fit.state(_coefficients(fit, free, own))
        except (UnderdeterminedError, np.linalg.LinAlgError):
            return -np.inf
        misfit = float(((state.difference / unit) ** 2).sum() + (own**2 / widths).sum())
        return -misfit / 2 if np.isfinite(misfit) else -np.inf

    return density


def _start(
    fit: ModalResiduals, whole: OneStagePath, free: IntArray, n_chains: int, rng: np.random.Generator
) -> FloatArray:
    """Return where chains begin, (n_chains, n_free): draws of the linearised posterior within the bounds."""
    belief, final = whole.belief, whole.path.final
    values, turn = np.linalg.eigh(belief.covariance[np.ix_(free, free)])
    drawn = rng.standard_normal((n_chains, len(free))) * np.sqrt(np.maximum(values, 0.0)) @ turn.T
    begin = belief.mean[free] + drawn
    lower, upper = _limits(fit, free)
    # Chains that begin at one place of a bound could not move by their differences.
    middle = changes(fit.parameterisation, final.values)[free]
    inside = middle + (np.clip(begin, lower, upper) - middle) * rng.random(begin.shape)
    return np.asarray(np.where((begin < lower) | (begin > upper), inside, begin))


def _correlation(chains: FloatArray, times: Any) -> FloatArray:
    """Return draws that count as one, (n_free,), of chains (n_steps, n_chains, n_free).

    Of chains some of which never moved it is not known: then each counts as one draw.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        found = np.asarray(times(chains, tol=0))
    return np.asarray(np.where(np.isfinite(found), found, float(len(chains))))
