"""How much of the noise is the force's and how much the responses', and what that does to FRFs."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.extraction.preprocessing.leakage import NoiseBias, WindowLeakage
from modallab.extraction.preprocessing.responses import Responses

FAINT = 0.05  # coherence below which a line tells nothing of how noise is shared out
ROUNDS = 12  # of least squares, weights and the force's spectrum renewed; they settle in a few
TINY = 1e-12  # noise over signal: none
QUIETEST = 4  # one in so many lines tells the force's noise where others leak
KNOWN = 0.2  # of the noise taken off: how well it is known, at its worst lines


@dataclass(frozen=True, eq=False)
class NoiseShares:
    """Noise over signal at each line."""

    force: FloatArray  # (n_freq,)
    response: FloatArray  # (n_freq, n_frf)


def noise_shares(responses: Responses, estimator: NoiseBias | None) -> NoiseShares:
    """Return noise of force and of responses over their signals.

    `(1 - g2)/g2 = r_i + r_o` nearly [5.8]. White noise n_f of the force is seen in all FRFs alike, white
    noise n_j of a response, an acceleration, the more the less it moves: `r_i + r_o = s (n_f + n_j/|H_j|^2)`,
    s(omega) one over the spectrum of the force. Least squares of relative differences, s and the two
    noises in turn. Of one FRF alone the spectrum of the force is taken to be flat.

    Parameters
    ----------
    estimator
        Of the FRFs; None where it is not known.
    """
    g2 = np.maximum(responses.coherence, TINY)
    seen = responses.coherence > FAINT
    loose = (1 - g2) / g2
    omega2 = (2 * np.pi * responses.freq[:, None]) ** 2
    # noise of a response raises H2 and not H1, so that H1 is the measure of how much it moves
    power = {None: 0.5, NoiseBias.H1: 0.0, NoiseBias.HV: 0.5, NoiseBias.H2: 1.0}[estimator]
    motion = np.abs(omega2 * responses.receptance * g2**power) ** 2
    size = np.median(motion, axis=0)
    weaker = size / np.maximum(motion, TINY * np.maximum(size, 1e-300))
    spectrum = np.ones(len(loose))
    force, response = _white(loose, weaker, seen / np.maximum(loose, TINY) ** 2)
    for _ in range(ROUNDS):
        model = force + response * weaker
        weight = seen / np.maximum(spectrum[:, None] * model, TINY) ** 2
        if loose.shape[1] > 1:
            total = (weight * model**2).sum(axis=1)
            spectrum = np.where(
                total > 0, (weight * model * loose).sum(axis=1) / np.where(total > 0, total, 1), 1.0
            )
        safe = np.maximum(spectrum, TINY)[:, None]
        force, response = _white(loose / safe, weaker, weight * safe**2)
    return NoiseShares(spectrum * force, spectrum[:, None] * response * weaker)


def _white(loose: FloatArray, weaker: FloatArray, weight: FloatArray) -> tuple[float, FloatArray]:
    """Return the force's noise and that of each response (n_frf,), neither below zero."""
    level, tilt, square = (np.maximum((weight * weaker**n).sum(axis=0), 1e-300) for n in range(3))
    sum_, slope = ((weight * weaker**n * loose).sum(axis=0) for n in range(2))
    sure = float((level - tilt**2 / square).sum())
    force = max(float((sum_ - tilt * slope / square).sum()) / sure, 0.0) if sure > 0 else 0.0
    return force, np.maximum((slope - force * tilt) / square, 0.0)


def force_noise_of_leaked(responses: Responses, leakage: WindowLeakage) -> NoiseShares:
    """Return noise of the force over its signal where lines leak; that of the responses is not told.

    What leaks is not coherent either. On the flanks it is known: about a line the response is straight, and
    its variance over the window's power spectrum is its slope squared times that of the window. Noise of a
    force that is white, with white noise, is all FRFs' and all lines', so that lines tell it where hardly
    anything else is incoherent. A force that an armature loads is not white: then none is told.
    """
    none = np.zeros(responses.coherence.shape)
    if leakage.source_mass > 0:
        return NoiseShares(none[:, 0], none)
    g2 = np.maximum(responses.coherence, TINY)
    inertance = responses.freq[:, None] ** 2 * responses.receptance
    slope = np.abs(np.gradient(inertance, axis=0))
    leaked = leakage.variance * (slope / np.maximum(np.abs(inertance), 1e-300)) ** 2
    left = np.median((1 - g2) / g2 - leaked, axis=1)
    quiet = np.argsort(np.median(leaked, axis=1), kind="stable")[: max(len(left) // QUIETEST, 1)]
    level = max(float(np.median(left[quiet])), 0.0)
    return NoiseShares(np.full(len(left), level), none)


def without_noise_bias(
    responses: Responses, shares: NoiseShares, estimator: NoiseBias | None
) -> tuple[Responses, FloatArray]:
    """Return the responses freed of what noise biases, and what bias may be left, relative (n_freq, n_frf).

    H1 is `H/(1 + r_i)` [5.6], H2 is `H (1 + r_o)` [5.7], Hv the root of their product nearly. Without
    knowledge of the estimator nothing is taken off, and all of it may be left but for that of the force at
    its usual level, which is of the scale only.
    """
    force = np.broadcast_to(shares.force[:, None], shares.response.shape)
    factor = {
        None: np.ones_like(force),
        NoiseBias.H1: 1 + force,
        NoiseBias.H2: 1 / (1 + shares.response),
        NoiseBias.HV: np.sqrt((1 + force) / (1 + shares.response)),
    }[estimator]
    if estimator is None:
        left = np.maximum(force - np.median(force, axis=0), 0.0) + shares.response
    else:
        left = KNOWN * np.abs(factor - 1)
    return replace(responses, receptance=responses.receptance * factor), left
