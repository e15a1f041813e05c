"""Residuals of a prediction in units of their random error."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import polygamma

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, logarithm
from modallab.diagnosis.residuals.observed import Observed, Predicted, VarianceRatios
from modallab.diagnosis.residuals.random_error import NUMERICAL
from modallab.estimation.force_noise import decorrelated

COARSE = 0.02  # squared relative error of H beyond which its logarithm gives way to the difference


@dataclass(frozen=True, eq=False)
class Residual:
    """Logarithmic ratios measured over predicted, each part over its own error: mean square 1 at best."""

    frf: ComplexArray  # (n_freq, n_out)
    force: FloatArray | None  # (n_freq, n_run)
    response: FloatArray | None  # (n_freq, n_out)
    excess_variance: Callable[[], FloatArray] | None = None  # of the response's variance, where power leaks
    variance_ratios: Callable[[], VarianceRatios] | None = None  # of all variances, where signals come back
    force_variance: FloatArray | float = 1.0  # that `force` is over
    averages: float = np.inf
    floor: float = NUMERICAL**2  # variance that a force has in any case
    lines_correlated: bool = False  # whether lines share random numbers beyond what a window mixes
    shared_noise: FloatArray | None = None  # see `Observed.shared_noise`

    @property
    def parts(self) -> dict[str, ComplexArray | FloatArray]:
        """The parts that were measured, by name."""
        every = {"frf": self.frf, "force": self.force, "response": self.response}
        return {name: part for name, part in every.items() if part is not None}

    def vector(self, where: BoolArray) -> FloatArray:
        """Return all residuals at the lines and channels of `where` (n_freq, n_out), independent and of
        unit variance each: what channels have in common through the force is taken once."""
        frf, response = self.frf, self.response
        if self.shared_noise is not None:
            frf = decorrelated(frf, self.shared_noise, where)
            response = None if response is None else decorrelated(response, self.shared_noise**2, where)
        frf = frf[where]
        parts = [np.sqrt(2) * frf.real, np.sqrt(2) * frf.imag]
        if self.force is not None:
            parts.append(self.force[_of_runs(where, self.force.shape[1])])
        if response is not None:
            parts.append(response[where])
        return np.concatenate(parts)

    @cached_property
    def rescaled(self) -> dict[str, ComplexArray | FloatArray]:
        """The parts, each over what it scatters by in truth, records that share their power included.

        A fit goes without: its weights would depend on its parameters.
        """
        parts = self.parts
        if self.response is not None and self.excess_variance is not None:
            parts["response"] = self.response / np.sqrt(self.excess_variance())
        if self.variance_ratios is None:
            return parts
        factors = self.variance_ratios()
        parts["frf"] = self.frf / np.sqrt(factors.frf)
        if self.response is not None:
            parts["response"] = parts["response"] / np.sqrt(factors.response)
        if self.force is not None:
            own = polygamma(1, self.averages / np.maximum(factors.force, NUMERICAL**2)) + self.floor
            parts["force"] = self.force * np.sqrt(self.force_variance / own)
        return parts

    def gaps(self, where: BoolArray) -> dict[str, float]:
        """Return the mean square of each part at the lines and channels of `where`."""
        return {
            name: float((np.abs(part[_of_runs(where, part.shape[1])]) ** 2).mean()) if where.any() else 0.0
            for name, part in self.rescaled.items()
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
    frf = normalised_difference(observed, predicted.h) / np.sqrt(2 * (observed.error**2 + widen**2))
    force = response = None
    variance = observed.force_variance + widen**2
    if observed.force is not None:
        force = np.log(observed.force / predicted.force) / np.sqrt(variance)
    if observed.incoherent is not None and observed.incoherent_variance is not None:
        spread = np.sqrt(observed.incoherent_variance + widen**2)
        response = np.log(observed.incoherent / predicted.incoherent) / spread
    return Residual(
        frf,
        force,
        response,
        predicted.excess_variance,
        predicted.variance_ratios,
        variance,
        observed.averages,
        observed.floor,
        predicted.lines_correlated,
        observed.shared_noise,
    )


def normalised_difference(observed: Observed, h: ComplexArray) -> ComplexArray:
    """Return by how much of itself a measured H1 differs from one predicted: over its error, of variance 1.

    Given G_ff, H1 is normal about its expectation and independent of G_xx (1 - coherence), by which it is
    weighed (Goodman 1963): the difference (H_m - H_p)/|H_m| over its error has mean square 1 at any
    coherence, and a fit that goes by it is not biased. But it has many valleys far from its goal, where
    ln(H_m/H_p) has one; that has the same law while the error is small, but for a bias: lines that came
    out large by chance weigh more, which their squared error makes up for. So the logarithm is used where
    random errors are small, and goes over into the difference where they are not.

    Parameters
    ----------
    h
        (n_freq, n_out), predicted.

    Returns
    -------
    (n_freq, n_out), 0 where nothing is known.
    """
    ratio = observed.h / np.where(observed.usable, h, 1.0)
    share = logarithm_weight(observed.error)
    of_ratio = logarithm(ratio) - observed.bias
    return np.where(observed.usable, share * of_ratio + (1 - share) * (1 - 1 / ratio), 0.0)


def logarithm_weight(error: FloatArray) -> FloatArray:
    """Return the share of the logarithm in `normalised_difference`, by the random error of |H|."""
    return np.asarray(1 / (1 + (2 * error**2 / COARSE) ** 2))


def inflation_weights(observed: Observed, where: BoolArray, widen: float) -> FloatArray:
    """Return what `widen` multiplies each entry of a residual's vector over `where` by."""
    frf = observed.error / np.sqrt(observed.error**2 + widen**2)
    force = response = None
    if observed.force is not None:
        share = np.sqrt(observed.force_variance / (observed.force_variance + widen**2))
        force = np.full(observed.force.shape, share)
    if observed.incoherent_variance is not None:
        response = np.sqrt(observed.incoherent_variance / (observed.incoherent_variance + widen**2))
    return Residual((1 + 1j) / np.sqrt(2) * frf, force, response).vector(where)


def error_ratio(narrow: Observed, wide: Observed) -> FloatArray:
    """Return by what each entry of a residual's vector over what is fitted is less with wider errors."""
    force = response = None
    if narrow.force is not None:
        force = np.full(narrow.force.shape, np.sqrt(narrow.force_variance / wide.force_variance))
    if narrow.incoherent_variance is not None and wide.incoherent_variance is not None:
        response = np.sqrt(narrow.incoherent_variance / wide.incoherent_variance)
    both = Residual((1 + 1j) / np.sqrt(2) * narrow.error / wide.error, force, response)
    return both.vector(narrow.fitted)


def correlation_lengths(observed: Observed, left: Residual, *, reach: int | None = None) -> dict[str, float]:
    """Return for each part how many lines one independent line stands for.

    Of a window alone it is known; leakage spreads the same few random numbers of a resonance over
    all lines, as do blows that differ, which the residuals' own correlation tells.

    Parameters
    ----------
    reach
        How far apart lines may be that have random numbers in common; any distance by default, but then
        what is missing and changes slowly from line to line looks like leakage too.
    """
    if not left.lines_correlated:
        return dict.fromkeys(left.parts, observed.correlation_length)
    return {
        name: _correlation(np.where(_of_runs(observed.usable, part.shape[1]), part, 0.0), reach)
        for name, part in left.rescaled.items()
    }


def gap_errors(
    observed: Observed, left: Residual, where: BoolArray, *, reach: int | None = None
) -> dict[str, float]:
    """Return the random error of each part's gap over `where` if nothing is missing; `reach` as above."""
    errors: dict[str, float] = {}
    for name, correlation in correlation_lengths(observed, left, reach=reach).items():
        part = left.parts[name]
        # A complex residual has two numbers in it, so its mean square scatters less.
        # It is weighed by a coherence that was measured: its square over that is an F-distributed one.
        weighed = 1 + 2 / max(observed.averages - 3, 0.1)
        squares = weighed if np.iscomplexobj(part) else 2.0
        seen = _of_runs(where, part.shape[1])
        count = max(int(seen.sum()), 1)
        shared = _shared(np.where(seen, left.rescaled[name], 0.0))
        errors[name] = float(np.sqrt(squares * correlation * shared / count))
    return errors


def gap_error(observed: Observed, left: Residual, where: BoolArray) -> float:
    """Return the random error of the whole gap over `where` if nothing is missing."""
    errors = np.array(list(gap_errors(observed, left, where).values()))
    return float(np.sqrt((errors**2).sum()) / len(errors))


def _shared(part: ComplexArray | FloatArray) -> float:
    """Return how many channels one independent channel stands for: noise of a force is in all of its run."""
    own = np.einsum("fi,fj->ij", part.conj(), part)
    size = np.sqrt(np.maximum(own.diagonal().real, 1e-300))
    likeness = np.abs(own / np.outer(size, size)) ** 2 - 1 / max(len(part), 1)  # that chance alone leaves
    np.fill_diagonal(likeness, 1.0)
    return float(np.maximum(likeness, 0.0).sum() / len(likeness))


def autocovariance(part: ComplexArray | FloatArray) -> ComplexArray:
    """Return the sums of products of residuals (n_freq, n) so many lines apart, (n_freq,)."""
    spectrum = np.fft.fft(part, 2 * len(part), axis=0)
    return np.asarray(np.fft.ifft((np.abs(spectrum) ** 2).sum(axis=1))[: len(part)])


def _correlation(part: ComplexArray | FloatArray, reach: int | None) -> float:
    """Return how many lines one independent line stands for: 1 + 2 sum (1 - k/n) |rho_k|^2 over the lags."""
    n = len(part)
    covariance = autocovariance(part)
    seen = 1 - np.arange(1, n) / n  # of n lines only n - k pairs are k apart
    rho = np.abs(covariance[1:]) / max(float(np.abs(covariance[0])), 1e-300) / seen
    return float(1 + 2 * (seen * np.minimum(rho, 1.0) ** 2)[:reach].sum())
