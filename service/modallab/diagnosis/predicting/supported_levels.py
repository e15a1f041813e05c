"""Noise of a force channel that no log book declares: whether the FRFs have the bias that it gives H1."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.diagnosis.predicting.settings import PREDICTION
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted
from modallab.diagnosis.residuals.residual import residual
from modallab.estimation.coherence import incoherent_ratio
from modallab.fe.structure import Structure
from modallab.rig.setup import RigSetup


def with_supported_force_noise(structure: Structure, setup: RigSetup, observed: Observed) -> Observed:
    """Return the measurement with free noise that does not bias H1, where its FRFs contradict the bias.

    Noise of the force lowers the coherence and biases H1 low. Noise in proportion to the responses lowers the
    coherence alike, without a bias of H1. Where no log book declares the noise, the coherence cannot
    distinguish them. The FRFs may, by the share of the bias that they show: 1 with noise of the force, 0
    without. The share says nothing where it is far from both, as the model deviates by more than the bias,
    nor where the noise does not explain the coherence, as the model has its resonances elsewhere.
    """
    levels = observed.free_levels
    if not levels.force_noise:
        return observed
    without = replace(observed, free_levels=replace(levels, biases_h1=False))
    with_noise, predicted = (
        SingleTestPredictor.of(structure, setup, each).predict(()) for each in (observed, without)
    )
    if not _explains_coherence(observed, predicted, with_noise):
        return observed
    share, error = _share_of_bias(observed, predicted, with_noise)
    near_zero = abs(share) < PREDICTION.bias_share
    contradicts = near_zero and 1 - share > PREDICTION.bias_errors * error
    return without if contradicts else observed


def _explains_coherence(observed: Observed, predicted: Predicted, with_noise: Predicted) -> bool:
    """Return whether noise of the force explains the coherence where it is most of what lowers it."""
    ratio = np.abs(with_noise.h) / np.maximum(np.abs(predicted.h), SAFE_DIVISOR)
    of_force = np.maximum(1 / np.maximum(ratio, SAFE_DIVISOR) - 1, 0.0)
    expected, measured = incoherent_ratio(with_noise.coherence), incoherent_ratio(observed.coherence)
    most = observed.fitted & (of_force > expected / 2)
    if not most.any():
        return False
    sizes = np.abs(observed.h[most]) / np.abs(with_noise.h[most])
    misfit = np.abs(np.log(sizes**2 * measured[most] / expected[most]))
    return bool(np.median(misfit) < PREDICTION.bias_errors / np.sqrt(max(observed.averages - 1, 1.0)))


def _share_of_bias(observed: Observed, predicted: Predicted, with_noise: Predicted) -> tuple[float, float]:
    """Return the share of the bias of H1 by noise of the force that FRFs show, and its standard error.

    By weighted least squares, with the weights of a Cauchy loss: a local effect that the model lacks changes
    the share little. The sensitivity of every FRF is free within a prior. The error is that by the scatter
    between blocks of lines, since a deviation of the model keeps its sign over many lines: Liang and Zeger,
    Biometrika 73 (1986), 13.

    Parameters
    ----------
    predicted, with_noise
        Predictions without and with the noise.
    """
    frf = residual(observed, predicted).frf
    biased = residual(observed, with_noise).frf - frf
    higher = residual(observed, replace(predicted, h=2 * predicted.h)).frf - frf
    weights = observed.fitted / (1 + np.abs(frf) ** 2) / observed.correlation_length
    blocks = np.array_split(np.arange(len(frf)), PREDICTION.bias_blocks)

    def products(a: ComplexArray, b: ComplexArray) -> FloatArray:
        """Return weighted scalar products (n_blocks, n_out)."""
        by_line = weights * (a.conj() * b).real
        return np.array([by_line[block].sum(axis=0) for block in blocks])

    of_bias, of_gains = products(biased, biased).sum(), products(higher, higher).sum(axis=0)
    if not of_bias > 0:
        return 0.0, np.inf
    prior = np.full(len(of_gains), PREDICTION.sensitivity_error**-2)
    mixed = products(biased, higher).sum(axis=0)
    curvature = np.block([[of_bias, mixed], [mixed[:, None], np.diag(of_gains + prior)]])
    covariance = np.linalg.inv(curvature)
    slopes = products(biased, frf).sum(), *products(higher, frf).sum(axis=0)
    share, *gains = -covariance @ slopes
    remaining = frf + share * biased + np.array(gains) * higher
    scores = np.column_stack([products(biased, remaining).sum(axis=1), products(higher, remaining)])
    scatter = scores.T @ scores + np.diag([0.0, *prior])
    return float(share), float(np.sqrt((covariance @ scatter @ covariance)[0, 0]))
