"""Correlation of the random errors of neighbouring lines, caused by the window of the records."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy.optimize

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.numerics import SAFE_DIVISOR, SUM_ROUNDING
from modallab.estimation.settings import ERROR_CORRELATION, SPECTRUM
from modallab.estimation.windows import WINDOWS, Window


@dataclass(frozen=True)
class ErrorCorrelation:
    """Correlation of the random errors of frequency lines, from the power of the noise over a record.

    For noise in one channel the correlation is the Fourier transform of the squared window. If the force is
    as random as the noise, an error is a product of both, and the correlation is the squared magnitude of
    that transform. An exponential window begins before the blow, which is time zero of an FRF.
    """

    window: Window
    """Window of the records."""
    random_force: bool = False
    """Whether the force is random from record to record."""
    delay: float = 0.0
    """1, time from the start of the record to the force over the record length."""

    @property
    def exponential(self) -> bool:
        """Whether the window is an exponential one."""
        return self.window.end < 1

    def by_separation(self, n: int) -> ComplexArray:
        """Return the correlation of the errors of a line and of the line 0 to n - 1 lines below it, (n,)."""
        separation = np.arange(n)
        power = self.window.samples(max(SPECTRUM.window_samples, 2 * n)) ** 2
        correlation = np.fft.fft(power)[:n] / power.sum() * np.exp(2j * np.pi * separation * self.delay)
        return np.asarray(np.abs(correlation) ** 2 + 0j if self.random_force else correlation)

    def matrix(self, n: int) -> ComplexArray:
        """Return the correlation of n neighbouring lines, (n, n)."""
        line = np.arange(n)
        return self.between(line[:, None] - line)

    def between(self, separation: IntArray) -> ComplexArray:
        """Return the correlation of the errors of two lines, in the shape of `separation`.

        Parameters
        ----------
        separation
            Number of the first line less that of the second.
        """
        correlation = self.by_separation(int(np.abs(separation).max(initial=0)) + 1)[np.abs(separation)]
        return np.asarray(np.where(separation >= 0, correlation, correlation.conj()))

    def power(self, n: int) -> FloatArray:
        """Return the power of the errors at n instants of a record from the force on, (n,) of sum 1.

        The Fourier transform of this power is the correlation by separation.
        """
        power = self.window.samples(n) ** 2
        power = np.roll(power / power.sum(), -round(self.delay * n))
        if self.random_force:
            power = np.fft.irfft(np.abs(np.fft.rfft(power)) ** 2, n)
        return np.asarray(power)

    def whitening(self, n: int) -> ComplexArray:
        """Return the matrix that makes the errors of n neighbouring lines independent, (n, n)."""
        return np.asarray(np.linalg.inv(np.linalg.cholesky(self.matrix(n) + SUM_ROUNDING * np.eye(n))))


def likeliest_correlation(
    complement: ComplexArray, residual: ComplexArray, window: Window | None
) -> ErrorCorrelation:
    """Return the usual correlation under which the residuals of smooth fits are most likely.

    Parameters
    ----------
    complement
        (n_fits, n_lines, n_spare) columns that the fits leave free.
    residual
        (n_fits, n_spare) lines along these columns.
    window
        Window of the records; None: unknown.
    """
    return min(_candidates(window), key=partial(_negative_likelihood, *_thinned(complement, residual)))


def refined_correlation(
    complement: ComplexArray, residual: ComplexArray, start: ErrorCorrelation
) -> tuple[ErrorCorrelation, ErrorCorrelation]:
    """Return the exponential window of largest likelihood, and one whose decay is a standard error off.

    Parameters
    ----------
    complement, residual
        As in `likeliest_correlation`.
    start
        An exponential window.
    """
    misfit = partial(_negative_likelihood, *_thinned(complement, residual))

    def at(parameters: FloatArray) -> ErrorCorrelation:
        end = np.clip(
            np.exp(-np.exp(parameters[0])), ERROR_CORRELATION.least_end, ERROR_CORRELATION.largest_end
        )
        delay = np.clip(parameters[1], 0.0, ERROR_CORRELATION.delays[-1])
        return ErrorCorrelation(replace(start.window, end=float(end)), delay=float(delay))

    first = np.array([np.log(-np.log(start.window.end)), start.delay])
    solution = scipy.optimize.minimize(
        lambda parameters: misfit(at(parameters)),
        first,
        method="Nelder-Mead",
        options={
            "initial_simplex": first + np.vstack([np.zeros(2), np.diag(ERROR_CORRELATION.first_steps)]),
            "xatol": ERROR_CORRELATION.parameter_tolerance,
            "fatol": ERROR_CORRELATION.likelihood_tolerance,
            "maxfev": ERROR_CORRELATION.evaluations,
        },
    )
    step = np.array([ERROR_CORRELATION.first_steps[0], 0.0])
    curvature = sum(misfit(at(solution.x + sign * step)) - float(solution.fun) for sign in (-1, 1))
    n_fits = len(_thinned(complement, residual)[1])
    error = step / np.sqrt(max(curvature * n_fits, SAFE_DIVISOR))
    return at(solution.x), at(solution.x + np.minimum(error, step))


def _thinned(complement: ComplexArray, residual: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    step = max(1, len(residual) // ERROR_CORRELATION.max_fits)
    return complement[::step], residual[::step]


def log_likelihoods(
    complement: ComplexArray, residual: ComplexArray, correlation: ErrorCorrelation
) -> tuple[FloatArray, FloatArray]:
    """Return the log-likelihood of each fit but for a constant, and its whitened sum of squares, (n_fits,).

    Each fit has its own variance, which limits the weight of fits whose model does not hold. The expectation
    of a sum of squares is n_spare times the variance of a line. Parameters as in `likeliest_correlation`.
    """
    n_lines = complement.shape[1]
    of_lines = correlation.matrix(n_lines) + SUM_ROUNDING * np.eye(n_lines)
    factor = np.linalg.cholesky(complement.conj().swapaxes(1, 2) @ of_lines @ complement)
    white = np.linalg.solve(factor, residual[..., None])[..., 0]
    log_determinant = 2 * np.log(np.diagonal(factor, axis1=1, axis2=2).real).sum(axis=1)
    squares = (np.abs(white) ** 2).sum(axis=1)
    return -complement.shape[2] * np.log(squares + SAFE_DIVISOR) - log_determinant, squares


def _negative_likelihood(
    complement: ComplexArray, residual: ComplexArray, correlation: ErrorCorrelation
) -> float:
    """Return minus the mean log-likelihood of a fit."""
    return -float(log_likelihoods(complement, residual, correlation)[0].mean())


def _candidates(window: Window | None) -> Iterator[ErrorCorrelation]:
    windows = WINDOWS.values() if window is None else (window,)
    shapes = {(member.coefficients, member.end < 1): member for member in windows}  # of responses
    for member in shapes.values():
        if member.end < 1:
            yield from (
                ErrorCorrelation(replace(member, end=end), delay=delay)
                for end in ERROR_CORRELATION.ends
                for delay in ERROR_CORRELATION.delays
            )
        else:
            yield from (ErrorCorrelation(member, random_force=random) for random in (False, True))
