"""Predictions of blows that die out within their record, near some effects, for derivatives."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from modallab.diagnosis.residuals.predicted import Predicted
from modallab.rig.effect import Effect
from modallab.rig.expected import coarse_spectra

if TYPE_CHECKING:
    from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor


def decayed_predictions(
    predictor: "SingleTestPredictor", effects: Sequence[Effect], exact: Predicted
) -> Callable[[Sequence[Effect]], Predicted]:
    """Return predictions near some effects, without what rings on beyond the record.

    It is nearly the same share of every line of the exact prediction, which is taken from there.

    Parameters
    ----------
    exact
        Exact prediction of these effects.
    """

    def decayed(near: Sequence[Effect]) -> Predicted:
        spectra = coarse_spectra(predictor.chain(near), 1, predictor.lines)
        return Predicted.of(predictor.observed.with_levels(spectra))

    approximate = decayed(effects)
    return lambda near: exact.times_ratio(decayed(near), approximate)
