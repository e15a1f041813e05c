"""Fit of the noise of forces and responses to incoherent response spectra."""

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.diagnosis.residuals.channel_noise import ChannelNoise, NoiseData
from modallab.diagnosis.residuals.noise_cost import NoiseCost, longest_step
from modallab.diagnosis.residuals.settings import FREE_LEVELS


def fit_channel_noise(
    data: NoiseData,
    *,
    force_noise: bool,
    response_noise: bool,
    start: ChannelNoise | None = None,
    last_step: float = FREE_LEVELS.last_step,
) -> ChannelNoise:
    """Return the noise that fits incoherent spectra best, by penalised least squares of their logarithms.

    With N of the force and P of a response the incoherent spectrum is I + P + |H|^2 G_ff N / (G_ff + N),
    I its part without noise; of several forces the sum, as if they were uncorrelated. Held-out channels have
    noise of their own, beside that of the force which the others tell. Coefficients of neighbouring functions
    differ little: Eilers and Marx, Statistical Science 11 (1996), 89.

    Parameters
    ----------
    start
        Noise of a prediction very much like this one; None: the start is found in the spectra.
    last_step
        Largest step of a coefficient that ends the fit.
    """
    informative = np.asarray(data.fitted.any(axis=0))
    if not force_noise or informative.all() or not informative.any():
        free = (force_noise, response_noise)
        return _levels(data, start, None, free=free, last_step=last_step)
    first = _levels(
        data.of_channels(informative),
        _of(start, informative),
        None,
        free=(True, response_noise),
        last_step=last_step,
    )
    others = _levels(
        data.of_channels(~informative),
        _of(start, ~informative),
        first.force,
        free=(False, response_noise),
        last_step=last_step,
    )
    response = None
    if first.response is not None and others.response is not None:
        response = np.zeros((len(first.response), len(informative)))
        response[:, informative], response[:, ~informative] = first.response, others.response
    return ChannelNoise(data.freq, first.force, response)


def _of(noise: ChannelNoise | None, channels: BoolArray) -> ChannelNoise | None:
    if noise is None or noise.response is None:
        return noise
    return ChannelNoise(noise.measured, noise.force, noise.response[:, channels])


def _levels(
    data: NoiseData,
    start: ChannelNoise | None,
    known_force: FloatArray | None,
    *,
    free: tuple[bool, bool],
    last_step: float,
) -> ChannelNoise:
    """Return the noise of channels by damped Newton steps of all coefficients.

    Parameters
    ----------
    known_force
        (n,) coefficients of the noise of the force where it is known; None: it has none, or is free.
    free
        Whether the noise of the force, and that of the responses, is free.
    last_step
        As in `fit_channel_noise`.
    """
    fit = NoiseCost(data, known_force, free)
    position = fit.start(start)
    cost, steps = fit.steps(position)
    for _ in range(FREE_LEVELS.max_iterations):
        of_force, of_responses = (step.clip(-FREE_LEVELS.max_step, FREE_LEVELS.max_step) for step in steps)
        last = longest_step((of_force, of_responses)) < last_step
        size = 1.0
        while True:
            new = fit.moved(position, (of_force, of_responses), size)
            if last:
                return fit.noise(new)
            new_cost, new_steps = fit.steps(new)
            if new_cost <= cost or size < FREE_LEVELS.least_share:
                break
            size /= 2
        gain_of_step = cost - new_cost
        if not gain_of_step >= 0:  # a cost that is not a number ends the fit too
            break
        position, cost, steps = new, new_cost, new_steps
        if gain_of_step <= FREE_LEVELS.tolerance * cost:
            break
    return fit.noise(position)
