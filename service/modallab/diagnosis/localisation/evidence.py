"""Evidence from residuals: frequency shifts of modes, loss of coherence, disagreement by line and channel."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.correlation.evidence import Evidence
from modallab.diagnosis.localisation.settings import EVIDENCE
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.residual import residual
from modallab.rig.effect import Effect
from modallab.rig.excitation import EXCITATIONS


def collect_evidence(predictor: SingleTestPredictor, effects: Sequence[Effect]) -> Evidence:
    """Return the disagreement of the measurement and the prediction with some effects."""
    observed, predicted = predictor.observed, predictor.predict(effects)
    remainder = residual(observed, predicted)
    modes = predictor.modes()
    excitation = EXCITATIONS[predictor.setup.analyser.excitation.kind]
    rows = [predictor.system.index(dof) for dof in observed.outputs]
    shifted = predictor.with_frequency_shift(effects, EVIDENCE.difference_step)
    return Evidence(
        freq=observed.freq,
        outputs=observed.outputs,
        drive=predictor.setup.drive,
        frf=remainder.frf,
        force=None if remainder.force is None else remainder.force[:, observed.forces],
        response=remainder.response,
        coherence_drop=np.where(observed.usable, predicted.coherence - observed.coherence, 0.0),
        weight=observed.fitted.astype(float),
        mode_frequency=modes.frequencies,
        frequency_shift=_frequency_shifts(observed, predicted, shifted, modes.frequencies),
        response_amplitude=np.abs(modes.shapes[rows]).T,
        random_averages=None if excitation.deterministic else observed.averages,
    )


def _frequency_shifts(
    observed: Observed, predicted: Predicted, shifted: Predicted, frequencies: FloatArray
) -> FloatArray:
    """Return the relative frequency shift of each mode, measured against predicted, (n_modes,).

    The shift follows from the shape of the mode's resonance. Where that gives less than one step of the
    grid of shifts, it follows by least squares from the derivative of the FRFs' logarithm.

    Parameters
    ----------
    shifted
        Prediction with all natural frequencies higher by `EVIDENCE.difference_step`.
    frequencies
        (n_modes,) Hz, natural frequencies of the model.
    """
    derivative = np.log(shifted.h / predicted.h) / EVIDENCE.difference_step
    log_ratio = np.log(observed.h / np.where(observed.usable, predicted.h, 1.0))
    weight = observed.usable / observed.error**2
    shifts = np.zeros(len(frequencies))
    edges = np.concatenate([[0.0], (frequencies[1:] + frequencies[:-1]) / 2, [np.inf]])
    spacing = np.diff(observed.freq).min()
    for i, frequency in enumerate(frequencies):
        reach = max(EVIDENCE.resonance_reach * frequency, EVIDENCE.least_reach * spacing)
        low, high = max(edges[i], frequency - reach), min(edges[i + 1], frequency + reach)
        near = (observed.freq > low) & (observed.freq < high)
        if near.sum() < EVIDENCE.fewest_lines:
            continue
        shifts[i] = _shift_of_shape(observed, predicted, near)
        if shifts[i] == 0:
            normal = (weight[near] * np.abs(derivative[near]) ** 2).sum()
            projected = (weight[near] * (derivative[near].conj() * log_ratio[near]).real).sum()
            shifts[i] = projected / max(normal, SAFE_DIVISOR)
    return shifts


def _shift_of_shape(observed: Observed, predicted: Predicted, near: BoolArray) -> float:
    """Return the relative shift of the predicted lines that fits the mean log magnitude best."""
    grid = np.linspace(-EVIDENCE.largest_shift, EVIDENCE.largest_shift, EVIDENCE.n_shifts)
    measured_level = np.log(np.abs(observed.h[near]) + SAFE_DIVISOR).mean(axis=1)
    level = np.log(np.abs(predicted.h) + SAFE_DIVISOR).mean(axis=1)
    candidates = np.array([np.interp(observed.freq[near], observed.freq * (1 + s), level) for s in grid])
    return float(grid[int((candidates - measured_level).std(axis=1).argmin())])
