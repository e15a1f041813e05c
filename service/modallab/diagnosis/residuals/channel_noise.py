"""Fit of the noise of forces and responses to incoherent response spectra."""

from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from scipy.interpolate import BSpline

from modallab.core.arrays import BoolArray, FloatArray, frozen
from modallab.core.numerics import SAFE_DIVISOR, SAFE_SQUARED_DIVISOR
from modallab.diagnosis.residuals.settings import FREE_LEVELS


def noise_functions(freq: FloatArray, measured: FloatArray) -> FloatArray:
    """Return the functions (n_freq, n) whose sum is the logarithm of a noise spectrum.

    Cubic B-splines over the logarithm of frequency, constant beyond the measured lines: wide beside a
    resonance, and as near to 1/f as to white noise. A single constant where lines are few.

    Parameters
    ----------
    measured
        Frequencies of the measured lines, Hz.
    """
    return _noise_functions(freq.tobytes(), measured.tobytes())


@lru_cache(maxsize=16)
def _noise_functions(freq_bytes: bytes, measured_bytes: bytes) -> FloatArray:
    """Return `noise_functions`, the same array for the same lines: every prediction of a test needs them."""
    freq, measured = (np.frombuffer(part) for part in (freq_bytes, measured_bytes))
    positive = measured[measured > 0]
    n = FREE_LEVELS.noise_functions
    if len(positive) < n * FREE_LEVELS.lines_per_function:
        return frozen(np.ones((len(freq), 1)), float, (None, 1))
    low, high = np.log(positive[[0, -1]])
    knots = np.concatenate([[low] * 3, np.linspace(low, high, n - 2), [high] * 3])
    at = np.log(np.clip(freq, positive[0], positive[-1])).clip(low, high)
    return frozen(BSpline.design_matrix(at, knots, 3).toarray(), float, (None, n))


@dataclass(frozen=True, eq=False)
class ChannelNoise:
    """Noise of the channels, as coefficients of `noise_functions`; zero where it has none."""

    measured: FloatArray
    """(n_lines,) Hz, lines that the functions are spread over."""
    force: FloatArray | None
    """(n,) of ln(N^2/Hz), of all force channels."""
    response: FloatArray | None
    """(n, n_out) of ln((m/s^2)^2/Hz), of the response channels, run by run."""

    def force_at(self, freq: FloatArray) -> FloatArray:
        """Return the noise of the force channels, (n_freq,) N^2/Hz."""
        if self.force is None:
            return np.zeros(len(freq))
        return np.asarray(np.exp(noise_functions(freq, self.measured) @ self.force))

    def response_at(self, freq: FloatArray) -> FloatArray | float:
        """Return the noise of the response channels, (n_freq, n_out) (m/s^2)^2/Hz."""
        if self.response is None:
            return 0.0
        return np.asarray(np.exp(noise_functions(freq, self.measured) @ self.response))


@dataclass(frozen=True, eq=False)
class NoiseData:
    """Incoherent response spectra G_xx (1 - coherence), (n_freq, n_out) each."""

    freq: FloatArray
    """(n_freq,) Hz."""
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
        by_channel = (item.name for item in fields(self) if item.name != "freq")
        return NoiseData(self.freq, **{name: getattr(self, name)[:, channels] for name in by_channel})


def fit_channel_noise(
    data: NoiseData, *, force_noise: bool, response_noise: bool, start: ChannelNoise | None = None
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
    """
    informative = np.asarray(data.fitted.any(axis=0))
    if not force_noise or informative.all() or not informative.any():
        return _levels(data, start, None, force_noise=force_noise, response_noise=response_noise)
    first = _levels(
        data.of_channels(informative),
        _of(start, informative),
        None,
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
    force_noise: bool,
    response_noise: bool,
) -> ChannelNoise:
    """Return the noise of channels by damped Gauss-Newton steps of all coefficients.

    Parameters
    ----------
    known_force
        (n,) coefficients of the noise of the force where it is known; None: it has none, or is free.
    """
    fit = _Fit(data, known_force, free=(force_noise, response_noise))
    position = fit.start(start)
    cost, steps = fit.steps(position)
    for _ in range(FREE_LEVELS.max_iterations):
        of_force, of_responses = (step.clip(-FREE_LEVELS.max_step, FREE_LEVELS.max_step) for step in steps)
        longest = max(float(np.abs(step).max(initial=0.0)) for step in (of_force, of_responses))
        last = longest < FREE_LEVELS.last_step
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


Coefficients = tuple[FloatArray, FloatArray]
"""Those of the noise of the force (n,), and of the responses (n, n_out)."""


class _Fit:
    """Gauss-Newton approximation of the cost in the coefficients of all levels."""

    def __init__(self, data: NoiseData, known_force: FloatArray | None, free: tuple[bool, bool]) -> None:
        self._data, self._known_force, self._free = data, known_force, free
        self._weight = data.weight * data.fitted if free[0] else data.weight
        self._log = np.log(data.measured)
        self._functions = noise_functions(data.freq, data.freq)
        n = self._functions.shape[1]
        self._products = (self._functions[:, :, None] * self._functions[:, None]).reshape(-1, n * n)
        differences = np.diff(np.eye(n), axis=0)
        self._penalty = differences.T @ differences / FREE_LEVELS.noise_slope**2
        floor = FREE_LEVELS.least_noise * np.median(data.coherent + data.other, axis=0)
        self._response_floor = np.log(np.maximum(floor, 0.0) + SAFE_SQUARED_DIVISOR)
        force_floor = FREE_LEVELS.least_noise * float(np.median(data.force))
        self._force_floor = float(np.log(force_floor + SAFE_SQUARED_DIVISOR))

    def start(self, near: ChannelNoise | None) -> Coefficients:
        """Return the coefficients of noise nearby; without it white noise of the weakest lines."""
        data, n = self._data, self._functions.shape[1]
        used = data.weight > 0
        force = np.full(n, -np.inf) if self._known_force is None else self._known_force
        response = np.full((n, data.measured.shape[1]), -np.inf)
        alike = near is not None and all(c is None or len(c) == n for c in (near.force, near.response))
        if self._free[0]:
            known = near.force if near is not None and alike else None
            force = np.full(n, np.log(_low_per_force(data, used))) if known is None else known
            force = np.maximum(force, self._force_floor)
        if self._free[1]:
            known = near.response if near is not None and alike else None
            low = np.log(_low(data.measured, used))
            response = np.maximum(np.tile(low, (n, 1)) if known is None else known, self._response_floor)
        return force, response

    def moved(self, position: Coefficients, steps: Coefficients, size: float) -> Coefficients:
        """Return the coefficients after a share of steps, not below the least noise."""
        force, response = position
        if self._free[0]:
            force = np.maximum(force + size * steps[0], self._force_floor)
        if self._free[1]:
            response = np.maximum(response + size * steps[1], self._response_floor)
        return force, response

    def noise(self, position: Coefficients) -> ChannelNoise:
        """Return the noise of coefficients."""
        has_force = self._free[0] or self._known_force is not None
        return ChannelNoise(
            self._data.freq, position[0] if has_force else None, position[1] if self._free[1] else None
        )

    def steps(self, position: Coefficients) -> tuple[float, Coefficients]:
        """Return the cost, and the steps of the coefficients of force (n,) and responses (n, n_out).

        Those of the responses are eliminated by the Schur complement.
        """
        data, functions = self._data, self._functions
        with_force = self._free[0] or self._known_force is not None
        force = np.exp(functions @ position[0]) if with_force else np.zeros(len(functions))
        response = np.exp(functions @ position[1]) if self._free[1] else 0.0
        share = data.force / (data.force + force[:, None, None])
        of_forces = data.gain * share * force[:, None, None]
        expected = data.other + response + of_forces.sum(axis=2)
        weight, misfit = self._weight, self._log - np.log(expected)
        weighted = weight * misfit
        by_response, by_force = response / expected, (of_forces * share).sum(axis=2) / expected
        cost = float((weighted * misfit).sum()) + self._roughness(position)
        if not np.isfinite(cost):
            return cost, (np.zeros(position[0].shape), np.zeros(position[1].shape))
        slope = (weighted * by_response).T @ functions - self._pull(position[1].T, free=self._free[1])
        curvature = self._curvature(weight * by_response**2)
        if not self._free[0]:
            return cost, (np.zeros(len(position[0])), np.linalg.solve(curvature, slope[..., None])[..., 0].T)
        force_slope = (weighted * by_force).sum(axis=1) @ functions - self._pull(position[0], free=True)
        own = self._curvature((weight * by_force**2).sum(axis=1, keepdims=True))[0]
        mixed = self._by_channel(weight * by_force * by_response)
        eliminated = np.linalg.solve(curvature, np.concatenate([mixed, slope[..., None]], axis=2))
        schur = own - (mixed @ eliminated[..., :-1]).sum(axis=0)
        schur += FREE_LEVELS.least_curvature * own
        step_force = np.linalg.solve(schur, force_slope - (mixed @ eliminated[..., -1:]).sum(axis=0)[:, 0])
        return cost, (step_force, (eliminated[..., -1] - eliminated[..., :-1] @ step_force).T)

    def _by_channel(self, weight: FloatArray) -> FloatArray:
        """Return the weighted products of the functions, (n_out, n, n)."""
        n = self._functions.shape[1]
        return np.asarray((weight.T @ self._products).reshape(-1, n, n))

    def _curvature(self, weight: FloatArray) -> FloatArray:
        """Return the second derivatives (n_out, n, n) of half the cost by the coefficients of one channel."""
        damping = FREE_LEVELS.least_curvature / FREE_LEVELS.noise_slope**2
        return self._by_channel(weight) + self._penalty + damping * np.eye(len(self._penalty))

    def _pull(self, coefficients: FloatArray, *, free: bool) -> FloatArray:
        """Return the slope of half the penalty, (.., n)."""
        return coefficients @ self._penalty if free else np.zeros(coefficients.shape)

    def _roughness(self, position: Coefficients) -> float:
        free = [part for part, is_free in zip(position, self._free, strict=True) if is_free]
        return float(sum(np.sum(part * (self._penalty @ part)) for part in free))


def _low_per_force(data: NoiseData, used: BoolArray) -> float:
    per_force = data.measured / np.maximum(data.gain.sum(axis=2), SAFE_DIVISOR)
    return float(_low(per_force, used & data.fitted).min())


def _low(values: FloatArray, used: BoolArray) -> FloatArray:
    """Return a low quantile of each column: where other power is added, there is more."""
    bounded = np.where(used, values, values.max())
    return np.asarray(np.quantile(bounded, FREE_LEVELS.initial_quantile, axis=0))
