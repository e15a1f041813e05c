"""Bias of FRFs by noise of the force and of the responses, and its correction."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING, SAFE_DIVISOR
from modallab.extraction.preprocessing.leakage import NoiseBias, WindowLeakage
from modallab.extraction.preprocessing.noise_ratios import NoiseToSignal
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.preprocessing.settings import NOISE_BIAS


def noise_to_signal(responses: Responses, estimator: NoiseBias | None) -> NoiseToSignal:
    """Return the noise-to-signal ratios of force and responses.

    `(1 - g2)/g2 = r_i + r_o` nearly [5.8]. White noise n_f of the force affects all FRFs equally; white noise
    n_j of an acceleration matters more where the response is small: `r_i + r_o = s (n_f + n_j/|H_j|^2)`,
    s(omega) being one over the spectrum of the force. Solution by least squares of relative differences,
    alternating between s and the two noises. With a single FRF the spectrum of the force is taken as flat.

    Parameters
    ----------
    responses
        From `responses_of`, with coherence.
    estimator
        Of the FRFs; None if unknown.
    """
    g2 = np.maximum(responses.coherence, PRODUCT_ROUNDING)
    usable = responses.coherence > NOISE_BIAS.minimum_coherence
    incoherence = (1 - g2) / g2
    omega2 = (2 * np.pi * responses.freq[:, None]) ** 2
    # noise of a response biases H2 and not H1, so that H1 = g2 H2 measures the motion
    power = {None: 0.5, NoiseBias.H1: 0.0, NoiseBias.HV: 0.5, NoiseBias.H2: 1.0}[estimator]
    motion = np.abs(omega2 * responses.receptance * g2**power) ** 2
    median_motion = np.median(motion, axis=0)
    inverse_motion = median_motion / np.maximum(
        motion, PRODUCT_ROUNDING * np.maximum(median_motion, SAFE_DIVISOR)
    )
    spectrum = np.ones(len(incoherence))
    force, response = _fit_white_noise(
        incoherence, inverse_motion, usable / np.maximum(incoherence, PRODUCT_ROUNDING) ** 2
    )
    for _ in range(NOISE_BIAS.iterations):
        model = force + response * inverse_motion
        weight = usable / np.maximum(spectrum[:, None] * model, PRODUCT_ROUNDING) ** 2
        if incoherence.shape[1] > 1:
            total = (weight * model**2).sum(axis=1)
            spectrum = np.where(
                total > 0, (weight * model * incoherence).sum(axis=1) / np.where(total > 0, total, 1), 1.0
            )
        safe = np.maximum(spectrum, PRODUCT_ROUNDING)[:, None]
        force, response = _fit_white_noise(incoherence / safe, inverse_motion, weight * safe**2)
    return NoiseToSignal(spectrum * force, spectrum[:, None] * response * inverse_motion)


def _fit_white_noise(
    incoherence: FloatArray, inverse_motion: FloatArray, weight: FloatArray
) -> tuple[float, FloatArray]:
    """Return the noise of the force and of each response (n_frf,), both not negative."""
    level, tilt, square = (
        np.maximum((weight * inverse_motion**n).sum(axis=0), SAFE_DIVISOR) for n in range(3)
    )
    sum_, slope = ((weight * inverse_motion**n * incoherence).sum(axis=0) for n in range(2))
    information = float((level - tilt**2 / square).sum())
    force = max(float((sum_ - tilt * slope / square).sum()) / information, 0.0) if information > 0 else 0.0
    return force, np.maximum((slope - force * tilt) / square, 0.0)


def leaked_force_noise(responses: Responses, leakage: WindowLeakage) -> NoiseToSignal:
    """Return the noise-to-signal ratio of the force where records leak; that of the responses is set to zero.

    Leakage is incoherent too. On the flanks of a resonance it is known: the response is nearly linear over
    the window's width, so that its variance there is its squared slope times the window's second moment.
    White noise of a white force is the same in all FRFs and at all lines, so that the lines of least leakage
    give it. The force of an exciter whose armature has mass is not white: then the result is zero.
    """
    zeros = np.zeros(responses.coherence.shape)
    if leakage.source_mass > 0:
        return NoiseToSignal(zeros[:, 0], zeros)
    g2 = np.maximum(responses.coherence, PRODUCT_ROUNDING)
    inertance = responses.freq[:, None] ** 2 * responses.receptance
    slope = np.abs(np.gradient(inertance, axis=0))
    leaked = leakage.variance * (slope / np.maximum(np.abs(inertance), SAFE_DIVISOR)) ** 2
    incoherence = np.median((1 - g2) / g2 - leaked, axis=1)
    quiet_lines = np.argsort(np.median(leaked, axis=1), kind="stable")[
        : max(len(incoherence) // NOISE_BIAS.quiet_line_divisor, 1)
    ]
    level = max(float(np.median(incoherence[quiet_lines])), 0.0)
    return NoiseToSignal(np.full(len(incoherence), level), zeros)


def without_noise_bias(
    responses: Responses, noise: NoiseToSignal, estimator: NoiseBias | None
) -> tuple[Responses, FloatArray]:
    """Return the responses without noise bias, and the relative bias that may remain, (n_freq, n_frf).

    H1 is `H/(1 + r_i)` [5.6], H2 is `H (1 + r_o)` [5.7], Hv is nearly the root of their product. If the
    estimator is unknown, nothing is corrected and the whole bias may remain, except for the median bias by
    noise of the force, which changes the scale only.

    Parameters
    ----------
    responses
        From `responses_of`.
    noise
        Noise-to-signal ratios of the same lines.
    estimator
        Of the FRFs; None if unknown.
    """
    force = np.broadcast_to(noise.force[:, None], noise.response.shape)
    factor = {
        None: np.ones_like(force),
        NoiseBias.H1: 1 + force,
        NoiseBias.H2: 1 / (1 + noise.response),
        NoiseBias.HV: np.sqrt((1 + force) / (1 + noise.response)),
    }[estimator]
    if estimator is None:
        remaining_bias = np.maximum(force - np.median(force, axis=0), 0.0) + noise.response
    else:
        remaining_bias = NOISE_BIAS.relative_uncertainty * np.abs(factor - 1)
    return replace(responses, receptance=responses.receptance * factor), remaining_bias
