"""Cost of the noise of forces and responses, and the steps that lower it."""

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.numerics import SAFE_DIVISOR, SAFE_SQUARED_DIVISOR
from modallab.diagnosis.residuals.channel_noise import ChannelNoise, NoiseData, noise_functions
from modallab.diagnosis.residuals.settings import FREE_LEVELS

Coefficients = tuple[FloatArray, FloatArray]
"""Those of the noise of the force (n,), and of the responses (n, n_out)."""


class NoiseCost:
    """Penalised squares of the logarithms of incoherent spectra, by the coefficients of all noise.

    Parameters
    ----------
    known_force
        (n,) coefficients of the noise of the force where it is known; None: it has none, or is free.
    free
        Whether the noise of the force, and that of the responses, is free.
    """

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
            if known is None:
                known = np.tile(np.log(_low(data.measured, used)), (n, 1))
            response = np.maximum(known, self._response_floor)
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

        Newton steps where they are short and the curvature is positive definite. Elsewhere Gauss-Newton
        steps, which lead from any start to nearly the same minimum, but converge linearly where misfits are
        large.
        """
        data, functions = self._data, self._functions
        with_force = self._free[0] or self._known_force is not None
        force = np.exp(functions @ position[0]) if with_force else np.zeros(len(functions))
        response = np.exp(functions @ position[1]) if self._free[1] else 0.0
        share = data.force / (data.force + force[:, None, None])
        of_forces = data.gain * share * force[:, None, None]
        expected = data.other + response + of_forces.sum(axis=2)
        misfit = self._log - np.log(expected)
        cost = float((self._weight * misfit**2).sum()) + self._roughness(position)
        if not np.isfinite(cost):
            return cost, (np.zeros(position[0].shape), np.zeros(position[1].shape))
        derivatives = _Derivatives(
            misfit,
            by_response=response / expected,
            by_force=(of_forces * share).sum(axis=2) / expected,
            by_force_twice=(of_forces * share * (2 * share - 1)).sum(axis=2) / expected,
        )
        with suppress(np.linalg.LinAlgError):
            step = self._newton_step(position, derivatives, second_order=True)
            if longest_step(step) < FREE_LEVELS.short_step:
                return cost, step
        return cost, self._newton_step(position, derivatives, second_order=False)

    def _newton_step(self, position: Coefficients, by: "_Derivatives", *, second_order: bool) -> Coefficients:
        """Return a Newton step of the coefficients, or a Gauss-Newton step without second derivatives.

        Coefficients at their lower bound with a step below it are fixed (active set). Those of the responses
        are eliminated by the Schur complement.

        Parameters
        ----------
        second_order
            Whether second derivatives of the spectra are included.

        Raises
        ------
        LinAlgError
            If second derivatives are included and the curvature is not positive definite.
        """
        functions, weight, weighted = self._functions, self._weight, self._weight * by.misfit
        twice = weight + second_order * weighted
        slope = (weighted * by.by_response).T @ functions - self._pull(position[1].T, free=self._free[1])
        at_floor = self._free[1] & (self._response_floor[:, None] >= position[1].T) & (slope < 0)
        slope, free = np.where(at_floor, 0.0, slope), ~at_floor
        curvature = self._curvature(twice * by.by_response**2 - second_order * weighted * by.by_response)
        curvature = _with_fixed(curvature, at_floor)
        if second_order:
            np.linalg.cholesky(curvature)  # raises unless it is positive definite
        if not self._free[0]:
            of_responses = np.linalg.solve(curvature, slope[..., None])[..., 0]
            return np.zeros(len(position[0])), np.asarray(of_responses.T)
        force_slope = (weighted * by.by_force).sum(axis=1) @ functions - self._pull(position[0], free=True)
        own = (twice * by.by_force**2 - second_order * weighted * by.by_force_twice).sum(
            axis=1, keepdims=True
        )
        (force_curvature,) = self._curvature(own)
        mixed = self._by_channel(twice * by.by_force * by.by_response) * free[:, :, None]
        eliminated = np.linalg.solve(curvature, np.concatenate([mixed, slope[..., None]], axis=2))
        columns, rest = eliminated[..., :-1], eliminated[..., -1]
        schur = force_curvature - np.einsum("cij,cik->jk", mixed, columns)
        schur += FREE_LEVELS.least_curvature * force_curvature
        force_slope = force_slope - np.einsum("cij,ci->j", mixed, rest)
        at_floor = (position[0] <= self._force_floor) & (force_slope < 0)
        schur = _with_fixed(schur, at_floor)
        if second_order:
            np.linalg.cholesky(schur)
        of_force = np.linalg.solve(schur, np.where(at_floor, 0.0, force_slope))
        return np.asarray(of_force), np.asarray((rest - columns @ of_force).T)

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


@dataclass(frozen=True, eq=False)
class _Derivatives:
    """Misfits of logarithms (n_freq, n_out), and derivatives of spectra over these by logarithms of noise."""

    misfit: FloatArray
    by_response: FloatArray
    """First and second ones alike: a spectrum is linear in the noise of its response."""
    by_force: FloatArray
    by_force_twice: FloatArray


def longest_step(steps: Coefficients) -> float:
    """Return the largest magnitude among steps."""
    return max(float(np.abs(part).max(initial=0.0)) for part in steps)


def _with_fixed(curvature: FloatArray, fixed: BoolArray) -> FloatArray:
    """Return curvatures (..., n, n) with fixed coefficients (..., n) decoupled from all others."""
    if not fixed.any():
        return curvature
    free = ~fixed
    coupled = curvature * (free[..., :, None] & free[..., None, :])
    return np.asarray(coupled + fixed[..., :, None] * np.eye(fixed.shape[-1]))


def _low_per_force(data: NoiseData, used: BoolArray) -> float:
    per_force = data.measured / np.maximum(data.gain.sum(axis=2), SAFE_DIVISOR)
    return float(_low(per_force, used & data.fitted).min())


def _low(values: FloatArray, used: BoolArray) -> FloatArray:
    """Return a low quantile of each column: where other power is added, there is more."""
    bounded = np.where(used, values, values.max())
    return np.asarray(np.quantile(bounded, FREE_LEVELS.initial_quantile, axis=0))
