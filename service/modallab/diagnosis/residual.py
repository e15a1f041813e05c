"""Residuals of a prediction in units of their random error."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.diagnosis.observed import Observed, Predicted


@dataclass(frozen=True, eq=False)
class Residual:
    """Logarithmic ratios measured over predicted, each part over its own error: mean square 1 at best."""

    frf: ComplexArray  # (n_freq, n_out)
    force: FloatArray | None  # (n_freq, n_run)
    response: FloatArray | None  # (n_freq, n_out)
    excess: Callable[[], FloatArray] | None = None  # of the response's variance, where power leaks

    @property
    def leaking(self) -> bool:
        """Whether power that does not repeat with the record was predicted."""
        return self.excess is not None

    @property
    def parts(self) -> dict[str, ComplexArray | FloatArray]:
        """The parts that were measured, by name."""
        every = {"frf": self.frf, "force": self.force, "response": self.response}
        return {name: part for name, part in every.items() if part is not None}

    def vector(self, where: BoolArray) -> FloatArray:
        """Return all residuals at the lines and channels of `where` (n_freq, n_out), unit variance each."""
        frf = self.frf[where]
        parts = [np.sqrt(2) * frf.real, np.sqrt(2) * frf.imag]
        if self.force is not None:
            parts.append(self.force[_of_runs(where, self.force.shape[1])])
        if self.response is not None:
            parts.append(self.response[where])
        return np.concatenate(parts)

    @cached_property
    def judged(self) -> dict[str, ComplexArray | FloatArray]:
        """The parts, each over what it scatters by in truth, records that share their power included.

        A fit goes without: its weights would depend on its parameters.
        """
        parts = self.parts
        if self.response is not None and self.excess is not None:
            parts["response"] = self.response / np.sqrt(self.excess())
        return parts

    def gaps(self, where: BoolArray) -> dict[str, float]:
        """Return the mean square of each part at the lines and channels of `where`."""
        return {
            name: float((np.abs(part[_of_runs(where, part.shape[1])]) ** 2).mean()) if where.any() else 0.0
            for name, part in self.judged.items()
        }

    def gap(self, where: BoolArray) -> float:
        """Return the mean of the parts' mean squares."""
        return float(np.mean(list(self.gaps(where).values())))


def _of_runs(where: BoolArray, n_run: int) -> BoolArray:
    return where if where.shape[1] == n_run else np.asarray(where.any(axis=1, keepdims=True))


def residual(observed: Observed, predicted: Predicted, *, widen: float = 0.0) -> Residual:
    """Return the whitened residual of a prediction at every line.

    Parameters
    ----------
    widen
        Relative error added to every random error, so that a fit far from its goal is drawn to the
        shape of the resonances before it minds their noise.
    """
    ratio = np.log(observed.h / np.where(observed.usable, predicted.h, 1.0))
    frf = np.where(observed.usable, ratio / np.sqrt(2 * (observed.error**2 + widen**2)), 0.0)
    force = response = None
    if observed.force is not None:
        force = np.log(observed.force / predicted.force) / np.sqrt(observed.force_variance + widen**2)
    if observed.incoherent is not None and observed.incoherent_variance is not None:
        spread = np.sqrt(observed.incoherent_variance + widen**2)
        response = np.log(observed.incoherent / predicted.incoherent) / spread
    return Residual(frf, force, response, predicted.excess)


def correlations(observed: Observed, left: Residual) -> dict[str, float]:
    """Return for each part how many lines one independent line stands for.

    Of a window alone it is known; leakage spreads the same few random numbers of a resonance over
    all lines, which the residuals' own correlation tells.
    """
    if not left.leaking:
        return dict.fromkeys(left.parts, observed.correlation)
    return {
        name: _correlation(np.where(_of_runs(observed.usable, part.shape[1]), part, 0.0))
        for name, part in left.judged.items()
    }


def scatters(observed: Observed, left: Residual, where: BoolArray) -> dict[str, float]:
    """Return the random error of each part's gap over `where` if nothing is missing."""
    errors: dict[str, float] = {}
    for name, correlation in correlations(observed, left).items():
        part = left.parts[name]
        # A complex residual has two numbers in it, so its mean square scatters less.
        squares = 1.0 if np.iscomplexobj(part) else 2.0
        count = max(int(_of_runs(where, part.shape[1]).sum()), 1)
        errors[name] = float(np.sqrt(squares * correlation / count))
    return errors


def scatter(observed: Observed, left: Residual, where: BoolArray) -> float:
    """Return the random error of the whole gap over `where` if nothing is missing."""
    errors = np.array(list(scatters(observed, left, where).values()))
    return float(np.sqrt((errors**2).sum()) / len(errors))


def _correlation(part: ComplexArray | FloatArray) -> float:
    """Return how many lines one independent line stands for: 1 + 2 sum (1 - k/n) |rho_k|^2 over all lags."""
    n = len(part)
    spectrum = np.fft.fft(part, 2 * n, axis=0)
    covariance = np.fft.ifft((np.abs(spectrum) ** 2).sum(axis=1))[:n]
    seen = 1 - np.arange(1, n) / n  # of n lines only n - k pairs are k apart
    rho = np.abs(covariance[1:]) / max(float(np.abs(covariance[0])), 1e-300) / seen
    return float(1 + 2 * (seen * np.minimum(rho, 1.0) ** 2).sum())
