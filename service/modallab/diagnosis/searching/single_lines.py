"""Effects that show in single lines, which coarse predictions may leave out."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.place import Channels
from modallab.diagnosis.fitting.fit import Fit
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.searching.round_settings import SINGLE_LINES
from modallab.diagnosis.searching.starting_values import scan_sizes
from modallab.rig.effect import Effect


def visible_at_single_lines(predictor: Predictor, base: Fit, suspects: Sequence[Effect]) -> list[Effect]:
    """Return the suspects that lines of incoherent spectra show, each with the scanned values that fit best.

    Of a long record mains hum is in none of the lines of a coarse prediction. None of several tests.

    Parameters
    ----------
    base
        Fit of the accepted effects.
    """
    observed, response = predictor.observed, base.residual.response
    if response is None or len(predictor.tests) > 1:
        return []
    fitted = np.flatnonzero(observed.fitted.any(axis=0))
    residuals = np.where(observed.usable, response, 0.0)[:, fitted]
    visible: list[Effect] = []
    for suspect in (suspect for suspect in suspects if suspect.line_frequencies):
        shown = np.any([_excess(observed.freq, residuals, at) for at in suspect.line_frequencies], axis=0)
        few = shown.sum() <= SINGLE_LINES.few_channels
        acted_on = [suspect.acts_on(observed.channels[i].response) for i in fitted]
        if isinstance(suspect.at, Channels) == few and 2 * shown[acted_on].sum() > sum(acted_on):
            visible.append(_best_size(predictor, base, suspect))
    return visible


def _excess(freq: FloatArray, residuals: FloatArray, frequency: float) -> BoolArray:
    """Return whether residuals (n_freq, n) at a frequency in the band exceed those beside it, (n,)."""
    line = int(np.abs(freq - frequency).argmin())
    distance = np.abs(np.arange(len(freq)) - line)
    beside = (distance > SINGLE_LINES.reach) & (distance <= SINGLE_LINES.reach + SINGLE_LINES.lines_beside)
    level = residuals[beside].max(axis=0, initial=0.0)
    inside = freq[0] <= frequency <= freq[-1]
    return np.asarray(inside & (residuals[line] > level + SINGLE_LINES.least_excess))


def _best_size(predictor: Predictor, base: Fit, suspect: Effect) -> Effect:
    """Return a suspect with those of its scanned values that leave the least chi-square at all lines."""
    at_fit = predictor.with_nuisances_at(base.nuisance_position)

    def chi_square(trial: Effect) -> float:
        vector = at_fit.residual([*base.effects, trial]).vector(at_fit.observed.fitted)
        return float(vector @ vector)

    values = suspect.scan_values(predictor.system, predictor.setup)
    return min(scan_sizes(suspect, values), key=chi_square)
