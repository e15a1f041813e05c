"""Fit of white noise of force and responses to incoherent response spectra."""

from dataclasses import dataclass, fields

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.numerics import SAFE_DIVISOR, SAFE_SQUARED_DIVISOR
from modallab.diagnosis.residuals.settings import FREE_LEVELS


@dataclass(frozen=True, eq=False)
class WhiteNoise:
    """White noise of the channels."""

    force: float
    """N^2/Hz, of all force channels."""
    response: FloatArray
    """(n_out,), (m/s^2)^2/Hz, of the response channels, run by run."""


@dataclass(frozen=True, eq=False)
class NoiseData:
    """Incoherent response spectra G_xx (1 - coherence), (n_freq, n_out) each."""

    measured: FloatArray
    """(m/s^2)^2/Hz."""
    weight: FloatArray
    """Inverse variance of its logarithm; 0 where it is not used."""
    fitted: BoolArray
    """Entries that tell the noise of the force."""
    other: FloatArray
    """What is incoherent without noise, as by leakage or a nonlinear force."""
    coherent: FloatArray
    """Response to the forces."""
    gain: FloatArray
    """1/kg^2, (n_freq, n_out, n_in), squared FRFs to the forces that act at once."""
    force: FloatArray
    """N^2/Hz, (n_freq, n_out, n_in), these forces without noise."""

    def of_channels(self, channels: BoolArray) -> "NoiseData":
        """Return the data of some response channels (n_out,)."""
        return NoiseData(**{item.name: getattr(self, item.name)[:, channels] for item in fields(self)})


def fit_white_noise(
    data: NoiseData, *, force_noise: bool, response_noise: bool, start: WhiteNoise | None = None
) -> WhiteNoise:
    """Return the noise that fits incoherent spectra best, by least squares of their logarithms.

    With N of the force and P of a response the incoherent spectrum is I + P + |H|^2 G_ff N / (G_ff + N),
    I its part without noise; of several forces the sum, as if they were uncorrelated. Held-out channels have
    noise of their own, beside that of the force which the others tell.

    Parameters
    ----------
    start
        Noise of a prediction very much like this one; None: the start is found in the spectra.
    """
    informative = np.asarray(data.fitted.any(axis=0))
    if not force_noise or informative.all() or not informative.any():
        return _levels(data, start, 0.0, force_noise=force_noise, response_noise=response_noise)
    first = _levels(
        data.of_channels(informative),
        _of(start, informative),
        0.0,
        force_noise=True,
        response_noise=response_noise,
    )
    others = _levels(
        data.of_channels(~informative),
        _of(start, ~informative),
        first.force,
        force_noise=False,
        response_noise=response_noise,
    )
    response = np.zeros(len(informative))
    response[informative], response[~informative] = first.response, others.response
    return WhiteNoise(first.force, response)


def _of(noise: WhiteNoise | None, channels: BoolArray) -> WhiteNoise | None:
    return None if noise is None else WhiteNoise(noise.force, noise.response[channels])


def _levels(
    data: NoiseData, start: WhiteNoise | None, force: float, *, force_noise: bool, response_noise: bool
) -> WhiteNoise:
    """Return the noise of channels by damped Newton steps of the logarithms of all levels.

    Those of the responses are eliminated by the Schur complement.

    Parameters
    ----------
    force
        N^2/Hz, noise of the force where it is known.
    """
    used = data.weight > 0
    floor = FREE_LEVELS.least_noise * np.median(data.coherent + data.other, axis=0) + SAFE_SQUARED_DIVISOR
    force_floor = FREE_LEVELS.least_noise * float(np.median(data.force)) + SAFE_SQUARED_DIVISOR
    response = np.zeros(data.measured.shape[1])
    if response_noise:
        first = _low(data.measured, used) if start is None else start.response
        response = np.maximum(first, floor)
    if force_noise:
        lowest = _low_per_force(data, used) if start is None else start.force
        force = max(lowest, force_floor)
    fit = _Fit(data, free=(force_noise, response_noise))
    cost, (steps_force, steps_response) = fit.steps(force, response)
    for _ in range(FREE_LEVELS.max_iterations):
        step_force = float(np.clip(steps_force, -FREE_LEVELS.max_step, FREE_LEVELS.max_step))
        step_response = np.clip(steps_response, -FREE_LEVELS.max_step, FREE_LEVELS.max_step)
        last = max(abs(step_force), float(np.abs(step_response).max(initial=0.0))) < FREE_LEVELS.last_step
        size = 1.0
        while True:
            new_force = max(force * np.exp(size * step_force), force_floor) if force_noise else force
            new_response = (
                np.maximum(response * np.exp(size * step_response), floor) if response_noise else response
            )
            if last:
                return WhiteNoise(new_force, new_response)
            new_cost, new_steps = fit.steps(new_force, new_response)
            if new_cost <= cost or size < FREE_LEVELS.least_share:
                break
            size /= 2
        gain_of_step = cost - new_cost
        if not gain_of_step >= 0:  # a cost that is not a number ends the fit too
            break
        force, response, cost, (steps_force, steps_response) = new_force, new_response, new_cost, new_steps
        if gain_of_step <= FREE_LEVELS.tolerance * cost:
            break
    return WhiteNoise(force, response)


def _low_per_force(data: NoiseData, used: BoolArray) -> float:
    per_force = data.measured / np.maximum(data.gain.sum(axis=2), SAFE_DIVISOR)
    return float(_low(per_force, used & data.fitted).min())


def _low(values: FloatArray, used: BoolArray) -> FloatArray:
    """Return a low quantile of each column: where other power is added, there is more."""
    bounded = np.where(used, values, values.max())
    return np.asarray(np.quantile(bounded, FREE_LEVELS.initial_quantile, axis=0))


class _Fit:
    """Quadratic approximation of the cost in the logarithms of all levels."""

    def __init__(self, data: NoiseData, free: tuple[bool, bool]) -> None:
        self._data, self._free = data, free
        self._weight = data.weight * data.fitted if free[0] else data.weight
        self._log = np.log(data.measured)

    def steps(self, force: float, response: FloatArray) -> tuple[float, tuple[float, FloatArray]]:
        """Return the cost, and the Newton steps of ln N and of ln P (n_out,)."""
        data = self._data
        share = data.force / (data.force + force)
        of_forces = data.gain * share * force
        expected = data.other + response + of_forces.sum(axis=2)
        misfit = self._log - np.log(expected)
        by_force = (of_forces * share).sum(axis=2) / expected
        by_response = response / expected
        weight = self._weight
        weighted = weight * misfit
        cost = float((weighted * misfit).sum())
        slope = (weighted * by_response).sum(axis=0)
        squares = (weight * by_response**2).sum(axis=0)
        curvature = _newton(squares, squares - slope + (weighted * by_response**2).sum(axis=0)) + SAFE_DIVISOR
        if not self._free[0]:
            return cost, (0.0, slope / curvature)
        own, force_slope = float((weight * by_force**2).sum()), float((weighted * by_force).sum())
        second = (of_forces * share * (2 * share - 1)).sum(axis=2) / expected - by_force**2
        own = float(_newton(own, own - float((weighted * second).sum()))) + SAFE_DIVISOR
        if not self._free[1]:
            return cost, (force_slope / own, slope)
        mixed = ((weight + weighted) * by_force * by_response).sum(axis=0)
        step_force = (force_slope - float((mixed * slope / curvature).sum())) / max(
            own - float((mixed**2 / curvature).sum()), FREE_LEVELS.least_curvature * own
        )
        return cost, (step_force, (slope - mixed * step_force) / curvature)


def _newton(gauss_newton: FloatArray | float, newton: FloatArray | float) -> FloatArray:
    """Return second derivatives of the cost; where they are small or negative those of Gauss-Newton."""
    return np.where(newton > FREE_LEVELS.least_newton * np.asarray(gauss_newton), newton, gauss_newton)
