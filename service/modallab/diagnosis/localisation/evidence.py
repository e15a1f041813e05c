"""From residuals to evidence: shifts of modes, drops of coherence, bands and channels that disagree."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.correlation.evidence import Evidence
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.observed import Observed, Predicted
from modallab.diagnosis.residuals.residual import residual
from modallab.rig.effect import Effect

SHIFTS = np.linspace(-0.1, 0.1, 81)  # relative frequency shifts that are looked for by shape
SMALL_SHIFT = 1e-5  # to differentiate by


def gather(predictor: Predictor, effects: Sequence[Effect]) -> Evidence:
    """Return what disagrees between the measurement and the prediction with some effects."""
    observed, predicted = predictor.observed, predictor.predict(effects)
    left = residual(observed, predicted)
    modes = predictor.modes()
    rows = [predictor.system.index(dof) for dof in observed.outputs]
    return Evidence(
        freq=observed.freq,
        outputs=observed.outputs,
        drive=predictor.setup.drive,
        frf=left.frf,
        force=left.force,
        response=left.response,
        coherence_drop=np.where(observed.usable, predicted.coherence - observed.coherence, 0.0),
        weight=observed.fitted.astype(float),
        mode_frequency=modes.frequencies,
        frequency_shift=_shifts(
            observed, predicted, predictor.with_frequency_shift(effects, SMALL_SHIFT), modes.frequencies
        ),
        response_amplitude=np.abs(modes.shapes[rows]).T,
    )


def _shifts(
    observed: Observed, predicted: Predicted, detuned: Predicted, frequencies: FloatArray
) -> FloatArray:
    """Return by how much of itself each mode's frequency differs.

    From the shape of its resonance; where that does not move by a step of `SHIFTS`, by least squares
    on how the logarithm of the FRFs changes with the frequencies.
    """
    change = np.log(detuned.h / predicted.h) / SMALL_SHIFT
    apart = np.log(observed.h / np.where(observed.usable, predicted.h, 1.0))
    weight = observed.usable / observed.error**2
    found = np.zeros(len(frequencies))
    edges = np.concatenate([[0.0], (frequencies[1:] + frequencies[:-1]) / 2, [np.inf]])
    for i, frequency in enumerate(frequencies):
        reach = max(0.15 * frequency, 4 * (observed.freq[1] - observed.freq[0]))
        low, high = max(edges[i], frequency - reach), min(edges[i + 1], frequency + reach)
        near = (observed.freq > low) & (observed.freq < high)
        if near.sum() < 5:
            continue
        found[i] = _shift_of_shape(observed, predicted, near)
        if found[i] == 0:
            known = (weight[near] * np.abs(change[near]) ** 2).sum()
            found[i] = (weight[near] * (change[near].conj() * apart[near]).real).sum() / max(known, 1e-300)
    return found


def _shift_of_shape(observed: Observed, predicted: Predicted, near: BoolArray) -> float:
    """Return the shift of the predicted lines that makes their mean magnitude most like the measured."""
    size_m = np.log(np.abs(observed.h[near]) + 1e-300).mean(axis=1)
    size_p = np.log(np.abs(predicted.h) + 1e-300).mean(axis=1)
    moved = np.array([np.interp(observed.freq[near], observed.freq * (1 + s), size_p) for s in SHIFTS])
    return float(SHIFTS[int((moved - size_m).std(axis=1).argmin())])
