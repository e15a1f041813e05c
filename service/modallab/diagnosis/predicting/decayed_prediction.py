"""Predictions of blows that die out within their record, near some effects, for derivatives."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.settings import FREE_LEVELS
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.effect import Effect
from modallab.rig.expected import coarse_spectra

if TYPE_CHECKING:
    from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor


def decayed_predictions(
    predictor: "SingleTestPredictor", effects: Sequence[Effect], exact: Predicted
) -> Callable[[Sequence[Effect]], Predicted]:
    """Return predictions near some effects, without what rings on beyond the record.

    It is nearly the same share of every line of the exact prediction, which is taken from there. The fit of
    free noise levels starts from those beside these effects.

    Parameters
    ----------
    exact
        Exact prediction of these effects.
    """
    observed = predictor.observed

    def spectra(near: Sequence[Effect]) -> CrossSpectra:
        return coarse_spectra(predictor.chain(near), 1, predictor.lines)

    at_effects = spectra(effects)
    noise = observed.channel_noise(at_effects)

    def predicted(spectra: CrossSpectra) -> Predicted:
        step = FREE_LEVELS.near_step
        return Predicted.of(observed.with_levels(spectra, start=noise, last_step=step))

    approximate = predicted(at_effects)
    return lambda near: exact.times_ratio(predicted(spectra(near)), approximate)
