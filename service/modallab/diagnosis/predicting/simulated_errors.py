"""Random errors of one test with distortion in bursts, from simulated tests."""

from collections.abc import Sequence
from functools import partial
from operator import is_
from typing import TYPE_CHECKING

from modallab.diagnosis.predicting.settings import PREDICTION
from modallab.diagnosis.residuals.free_levels import at_level_of
from modallab.diagnosis.residuals.predicted import VarianceRatios
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.added_noise import AddedNoise
from modallab.rig.chain import Chain
from modallab.rig.effect import Effect
from modallab.rig.expected import expected_spectra
from modallab.rig.periodic_variance import VarianceFactors
from modallab.rig.simulated_variance import is_intermittent
from modallab.rig.spectrum_settings import SIMULATED_VARIANCE

if TYPE_CHECKING:
    from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor


def simulated_variance_ratios(
    predictor: "SingleTestPredictor", effects: Sequence[Effect]
) -> VarianceRatios | None:
    """Return variance ratios of many simulated tests; None without distortion in bursts."""
    if not is_intermittent(effects, predictor.setup):
        return None
    measuring_chain = predictor.chain(effects)
    spectra, n_tests = expected_spectra(measuring_chain), SIMULATED_VARIANCE.n_tests
    factors = simulated_factors(predictor, measuring_chain, spectra, effects, n_tests)
    return None if factors is None else VarianceRatios.of(factors, spectra).at(predictor.lines)


def simulated_factors(
    predictor: "SingleTestPredictor",
    measuring_chain: Chain,
    spectra: CrossSpectra,
    effects: Sequence[Effect],
    repeats: int | None = None,
) -> VarianceFactors | None:
    """Return the variance factors of a chain with some effects, and charge the predictor's budget for them.

    Parameters
    ----------
    spectra
        `expected_spectra(measuring_chain)`.
    repeats
        Number of simulated tests; None: as the settings have it.
    """
    smoothed = [effect.smoothed(predictor.system, predictor.setup) for effect in effects]
    if not all(map(is_, smoothed, effects)):
        measuring_chain = predictor.chain(smoothed)
        spectra = expected_spectra(measuring_chain)
    n_before = predictor.simulated.n_simulated
    noise = partial(_open_noise, predictor, spectra)
    factors = predictor.simulated.factors(measuring_chain, spectra, smoothed, noise=noise, repeats=repeats)
    cost = PREDICTION.stepping_cost * len(measuring_chain.runs[0].local_forces)
    predictor.budget.spend(cost * (predictor.simulated.n_simulated - n_before))
    return factors


def _open_noise(predictor: "SingleTestPredictor", spectra: CrossSpectra) -> AddedNoise | None:
    """Return the noise that the log book leaves open, as it is fitted beside expected spectra."""
    if not predictor.observed.free_levels.noise:
        return None
    noisy = predictor.observed.with_levels(spectra, predictor.lines)
    return AddedNoise.between(spectra, at_level_of(spectra, noisy))
