"""Fit of white noise of force and responses to incoherent response spectra."""

from dataclasses import dataclass

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


def fit_white_noise(
    data: NoiseData, *, force_noise: bool, response_noise: bool, start: WhiteNoise | None = None
) -> WhiteNoise:
    """Return the noise that fits incoherent spectra best, by least squares of their logarithms.

    With N of the force and P of a response the incoherent spectrum is I + P + |H|^2 G_ff N / (G_ff + N),
    I its part without noise; of several forces the sum, as if they were uncorrelated. The logarithms of all
    levels are fitted by damped Gauss-Newton steps, those of the responses eliminated by the Schur complement.

    Parameters
    ----------
    start
        Noise of a prediction very much like this one; None: the start is found in the spectra.
    """
    n_out = data.measured.shape[1]
    used = data.weight > 0
    floor = FREE_LEVELS.least_noise * np.median(data.coherent + data.other, axis=0) + SAFE_SQUARED_DIVISOR
    force_floor = FREE_LEVELS.least_noise * float(np.median(data.force)) + SAFE_SQUARED_DIVISOR
    response, force = np.zeros(n_out), 0.0
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
        size = 1.0
        while True:
            new_force = max(force * np.exp(size * step_force), force_floor) if force_noise else 0.0
            new_response = (
                np.maximum(response * np.exp(size * step_response), floor) if response_noise else response
            )
            new_cost, new_steps = fit.steps(new_force, new_response)
            if new_cost <= cost or size < FREE_LEVELS.least_share:
                break
            size /= 2
        gain_of_step = cost - new_cost
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
    """Normal equations of the logarithms of all levels."""

    def __init__(self, data: NoiseData, free: tuple[bool, bool]) -> None:
        self._data, self._free = data, free
        self._weight_of_force = data.weight * data.fitted
        self._log = np.log(data.measured)

    def steps(self, force: float, response: FloatArray) -> tuple[float, tuple[float, FloatArray]]:
        """Return the cost, and the Gauss-Newton steps of ln N and of ln P (n_out,)."""
        data = self._data
        share = data.force / (data.force + force)
        of_forces = data.gain * share * force
        expected = data.other + response + of_forces.sum(axis=2)
        misfit = self._log - np.log(expected)
        by_force = (of_forces * share).sum(axis=2) / expected
        by_response = response / expected
        weight = data.weight
        cost = float((weight * misfit**2).sum())
        curvature = (weight * by_response**2).sum(axis=0) + SAFE_DIVISOR
        gradient = (weight * by_response * misfit).sum(axis=0)
        if not self._free[0]:
            return cost, (0.0, gradient / curvature)
        # Held-out FRFs have noise of their own, but take no part in that of the force.
        weight = self._weight_of_force
        own = float((weight * by_force**2).sum()) + SAFE_DIVISOR
        pull = float((weight * by_force * misfit).sum())
        if not self._free[1]:
            return cost, (pull / own, gradient)
        mixed = (weight * by_force * by_response).sum(axis=0)
        step_force = (pull - float((mixed * gradient / curvature).sum())) / max(
            own - float((mixed**2 / curvature).sum()), FREE_LEVELS.least_curvature * own
        )
        return cost, (step_force, (gradient - mixed * step_force) / curvature)
