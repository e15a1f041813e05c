"""Covariance of the random errors of lines with leakage."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.preprocessing.leakage import NoiseBias, Signals, SinglePole, WindowLeakage


@dataclass(frozen=True, eq=False)
class LineErrors:
    """Second moments of the relative errors e of lines, (..., n_lines, n_lines).

    Covariance and relation (pseudo-covariance) are both needed: leakage brings the same few random numbers
    into many lines, with a phase that rotates from line to line, so that real and imaginary parts have
    unequal variances and are correlated.
    """

    covariance: ComplexArray
    """E[e_k conj(e_l)]."""
    relation: ComplexArray
    """E[e_k e_l]."""

    @classmethod
    def circular(cls, covariance: FloatArray) -> Self:
        """Return errors of random phase, as those by noise are."""
        return cls(covariance.astype(complex), np.zeros(covariance.shape, complex))

    def scaled(self, factor: float) -> Self:
        """Return errors with second moments larger by a factor."""
        return replace(self, covariance=factor * self.covariance, relation=factor * self.relation)

    def with_noise(self, covariance: FloatArray) -> Self:
        """Return the sum of these errors and of independent circular ones, (..., n_lines, n_lines)."""
        return replace(self, covariance=self.covariance + covariance)

    def propagate(self, influence: ComplexArray) -> FloatArray:
        """Return the covariance of n sums `Re(sum_k influence_k e_k)`; `influence` (..., n, n_lines)."""
        circular = influence @ self.covariance @ influence.conj().swapaxes(-1, -2)
        improper = influence @ self.relation @ influence.swapaxes(-1, -2)
        return np.asarray((circular + improper).real / 2)


@dataclass(frozen=True, eq=False)
class LeakedLines:
    """Relative errors of lines as quadratic forms of Gaussian variables.

    `e_k = conj(z_k)^T form_k z_k` less its mean; z contains the response of the resonance to the source, and
    the source.
    """

    form: ComplexArray
    """(..., n_lines, 2, 2)."""
    moments: ComplexArray
    """(..., n_lines, n_lines, 2, 2) E[conj(z_k) z_l^T]."""

    @property
    def errors(self) -> LineErrors:
        """Second moments of the errors of one record; of n nearly independent records they are one n-th.

        The mean of a product of four Gaussian variables follows from means of pairs: Isserlis (1918),
        Biometrika 12, 134-139.
        """
        form_moments = self.form[..., :, None, :, :] @ self.moments.conj()
        second_form = self.form[..., None, :, :, :]
        circular = (form_moments @ second_form.conj().swapaxes(-1, -2)) * self.moments
        return LineErrors(
            circular.sum(axis=(-2, -1)), ((form_moments @ second_form) * self.moments).sum(axis=(-2, -1))
        )


def leaked_lines(
    leakage: WindowLeakage, freq: FloatArray, spacing: float, response: SinglePole, drive: SinglePole
) -> LeakedLines:
    """Return the relative errors of lines by leakage alone.

    An FRF estimate from Gaussian records has the error `conj(P) V / E[conj(P) F H]`, averaged over the
    records. P is the force for H1 and the response for H2; V is `X - H F`, the part of the response X that
    the force F of the same line does not explain with the expected H: Bendat and Piersol (1986), Random Data,
    chapter 9. The error of Hv is half the sum of those of H1 and H2. Force and response are each the response
    of a pole to the source and a part of the source.

    Parameters
    ----------
    leakage
        Of the window of the records.
    freq, spacing, response, drive
        As in `WindowLeakage.correction`; lines are multiples of `spacing` apart.
    """
    signals = leakage.signals(freq, spacing, response, drive)
    moments = _moments(leakage, signals, np.rint(freq / spacing).astype(np.int64))
    line_moments = np.diagonal(moments, axis1=-4, axis2=-3)  # (..., 2, 2, n_lines)
    shape = np.broadcast_shapes(*(part.shape for part in (*signals.force, *signals.motion)))
    force, motion = (
        np.stack([np.broadcast_to(part, shape) for part in signal], axis=-1)
        for signal in (signals.force, signals.motion)
    )

    def mean(first: ComplexArray, second: ComplexArray) -> ComplexArray:
        """Return E[conj(first) second] of every line."""
        return np.asarray(np.einsum("...na,...abn,...nb->...n", first.conj(), line_moments, second))

    ff, fx, xx = mean(force, force), mean(force, motion), mean(motion, motion)
    by_h1 = _error_form(force, motion - (fx / _not_zero(ff))[..., None] * force, fx)
    by_h2 = _error_form(motion, motion - (xx / _not_zero(fx.conj()))[..., None] * force, xx)
    form = {NoiseBias.H1: by_h1, NoiseBias.H2: by_h2, NoiseBias.HV: (by_h1 + by_h2) / 2}[leakage.estimator]
    return LeakedLines(form, moments)


def white_error_correlation(leakage: WindowLeakage, freq: FloatArray, spacing: float) -> FloatArray:
    """Return the correlation of the errors of lines by white noise, (..., n_lines, n_lines)."""
    line = np.rint(freq / spacing).astype(np.int64)
    return np.asarray(np.abs(_white_correlation(leakage, line)) ** 2)


def _error_form(p: ComplexArray, v: ComplexArray, size: ComplexArray) -> ComplexArray:
    """Return the quadratic form of the relative error, (..., n_lines, 2, 2)."""
    return np.asarray(p.conj()[..., :, None] * v[..., None, :] / _not_zero(size)[..., None, None])


def _moments(leakage: WindowLeakage, signals: Signals, line: IntArray) -> ComplexArray:
    """Return E[conj(z_k) z_l^T], (..., n_lines, n_lines, 2, 2), in closed form for a pole."""
    separation = line[..., :, None] - line[..., None, :]
    largest_separation = min(int(np.abs(separation).max(initial=0)), leakage.ambiguity.shape[1] - 1)
    mixing = leakage.ambiguity[:, : largest_separation + 1]
    two_sided = np.concatenate([mixing[:, :0:-1].conj(), mixing], axis=1)  # negative and positive separations
    pole_spectra = signals.pole_response(leakage) @ two_sided  # (..., l, k - l)
    position = (-separation).clip(-largest_separation, largest_separation) + largest_separation  # (..., l, k)
    shape = np.broadcast_shapes(pole_spectra.shape[:-1], position.shape[:-1])
    cross_power = np.take_along_axis(
        np.broadcast_to(pole_spectra, (*shape, pole_spectra.shape[-1])),
        np.broadcast_to(position, (*shape, position.shape[-1])),
        axis=-1,
    ).swapaxes(-1, -2)
    damping = signals.gap.imag
    adjoint = cross_power.conj().swapaxes(-1, -2)
    power = (cross_power - adjoint) / (-1j * (damping[..., :, None] + damping[..., None, :]))
    white = np.broadcast_to(_white_correlation(leakage, line), cross_power.shape)
    rows = [np.stack([power, adjoint], axis=-1), np.stack([cross_power, white], axis=-1)]
    return np.stack(rows, axis=-2)


def _white_correlation(leakage: WindowLeakage, line: IntArray) -> ComplexArray:
    """Return the correlation of lines of white noise, (..., n_lines, n_lines)."""
    separation = line[..., :, None] - line[..., None, :]
    correlation = leakage.white_correlation[np.abs(separation).clip(max=len(leakage.white_correlation) - 1)]
    return np.asarray(np.where(separation < 0, correlation.conj(), correlation))


def _not_zero(values: ComplexArray) -> ComplexArray:
    return np.asarray(np.where(values == 0, 1, values))
