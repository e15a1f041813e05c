"""Residuals of a prediction in units of their random error."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.diagnosis.observed import Observed, Predicted


@dataclass(frozen=True, eq=False)
class Residual:
    """Logarithmic ratios measured over predicted, each part over its own error: mean square 1 at best."""

    frf: ComplexArray  # (n_freq, n_out)
    force: FloatArray | None  # (n_freq, n_run)
    response: FloatArray | None  # (n_freq, n_out)

    def vector(self, where: BoolArray) -> FloatArray:
        """Return all residuals at the lines and channels of `where` (n_freq, n_out), unit variance each."""
        frf = self.frf[where]
        parts = [np.sqrt(2) * frf.real, np.sqrt(2) * frf.imag]
        if self.force is not None:
            parts.append(self.force[_of_runs(where, self.force.shape[1])])
        if self.response is not None:
            parts.append(self.response[where])
        return np.concatenate(parts)

    def gaps(self, where: BoolArray) -> dict[str, float]:
        """Return the mean square of each part at the lines and channels of `where`."""
        found = {"frf": float((np.abs(self.frf[where]) ** 2).mean()) if where.any() else 0.0}
        if self.force is not None:
            runs = _of_runs(where, self.force.shape[1])
            found["force"] = float((self.force[runs] ** 2).mean()) if runs.any() else 0.0
        if self.response is not None:
            found["response"] = float((self.response[where] ** 2).mean()) if where.any() else 0.0
        return found

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
    return Residual(frf, force, response)


def scatter(observed: Observed, where: BoolArray, parts: int) -> float:
    """Return the random error of a gap over `where` if nothing is missing."""
    count = max(int(where.sum()), 1)
    return float(np.sqrt(2.0 * observed.correlation / (count * parts)))
