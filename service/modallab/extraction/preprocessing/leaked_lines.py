"""How the random errors of leaked lines go together."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.preprocessing.leakage import NoiseBias, OnePole, Signals, WindowLeakage


@dataclass(frozen=True, eq=False)
class LineErrors:
    """Second moments of relative errors e of lines, (..., n_lines, n_lines).

    Both are needed: what leaks is of the same few random numbers in many lines, and turns from one to the
    next, so that its real and imaginary parts are neither alike nor independent.
    """

    covariance: ComplexArray  # E[e_k conj(e_l)]
    relation: ComplexArray  # E[e_k e_l]

    def through(self, influence: ComplexArray) -> FloatArray:
        """Return the covariance of n sums `Re(sum_k influence_k e_k)`; `influence` (..., n, n_lines)."""
        circular = influence @ self.covariance @ influence.conj().swapaxes(-1, -2)
        turned = influence @ self.relation @ influence.swapaxes(-1, -2)
        return np.asarray((circular + turned).real / 2)


@dataclass(frozen=True, eq=False)
class LeakedLines:
    """Relative errors of lines as forms of what a record holds: `e_k = conj(z_k)^T form_k z_k` less its mean.

    z is Gaussian: the response of the resonance to the source, and the source.
    """

    form: ComplexArray  # (..., n_lines, 2, 2)
    moments: ComplexArray  # (..., n_lines, n_lines, 2, 2) E[conj(z_k) z_l^T]

    @property
    def errors(self) -> LineErrors:
        """Those of one record; of n records, which leakage hardly ties together, one n-th of them.

        Means of products of four Gaussian numbers are those of pairs: Isserlis (1918), Biometrika 12,
        134-139.
        """
        half = self.form[..., :, None, :, :] @ self.moments.conj()
        other = self.form[..., None, :, :, :]
        circular = (half @ other.conj().swapaxes(-1, -2)) * self.moments
        return LineErrors(circular.sum(axis=(-2, -1)), ((half @ other) * self.moments).sum(axis=(-2, -1)))


def leaked_lines(
    leakage: WindowLeakage, freq: FloatArray, spacing: float, response: OnePole, drive: OnePole
) -> LeakedLines:
    """Return the errors of lines that leakage alone makes, over what is expected of them.

    An estimate from Gaussian records is wrong by the mean over these of `conj(P) V / E[conj(P) F H]`: P is
    the force for H1 and the response for H2, and V the part of the response X that a line's own force F does
    not explain, `X - H F` with H as expected: Bendat and Piersol (1986), Random Data, chapter 9. Hv is wrong
    by half of what H1 and H2 are. Force and response are a pole's response to the source and a part of the
    source.

    Parameters
    ----------
    leakage
        What window cut the records.
    freq, spacing, response, drive
        As of `WindowLeakage.undone`; lines one `spacing` or several apart.
    """
    near = leakage.signals(freq, spacing, response, drive)
    moments = _moments(leakage, near, np.rint(freq / spacing).astype(np.int64))
    own = np.diagonal(moments, axis1=-4, axis2=-3)  # (..., 2, 2, n_lines)
    shape = np.broadcast_shapes(*(part.shape for part in (*near.force, *near.motion)))
    force, motion = (
        np.stack([np.broadcast_to(part, shape) for part in signal], axis=-1)
        for signal in (near.force, near.motion)
    )

    def mean(left: ComplexArray, right: ComplexArray) -> ComplexArray:
        """Return E[conj(left) right] of every line."""
        return np.asarray(np.einsum("...na,...abn,...nb->...n", left.conj(), own, right))

    ff, fx, xx = mean(force, force), mean(force, motion), mean(motion, motion)
    by_h1 = _form(force, motion - (fx / _not_zero(ff))[..., None] * force, fx)
    by_h2 = _form(motion, motion - (xx / _not_zero(fx.conj()))[..., None] * force, xx)
    form = {NoiseBias.H1: by_h1, NoiseBias.H2: by_h2, NoiseBias.HV: (by_h1 + by_h2) / 2}[leakage.estimator]
    return LeakedLines(form, moments)


def white_errors(leakage: WindowLeakage, freq: FloatArray, spacing: float) -> FloatArray:
    """Return the correlation of errors that white noise makes of lines, (..., n_lines, n_lines)."""
    line = np.rint(freq / spacing).astype(np.int64)
    return np.asarray(np.abs(_together(leakage, line)) ** 2)


def _form(p: ComplexArray, v: ComplexArray, size: ComplexArray) -> ComplexArray:
    return np.asarray(p.conj()[..., :, None] * v[..., None, :] / _not_zero(size)[..., None, None])


def _moments(leakage: WindowLeakage, near: Signals, line: IntArray) -> ComplexArray:
    """Return E[conj(z_k) z_l^T], (..., n_lines, n_lines, 2, 2), in closed form for a pole."""
    apart = line[..., :, None] - line[..., None, :]
    reach = min(int(np.abs(apart).max(initial=0)), leakage.mixing.shape[1] - 1)
    mixing = leakage.mixing[:, : reach + 1]
    both = np.concatenate([mixing[:, :0:-1].conj(), mixing], axis=1)  # so many lines before, and after
    turned = near.turning(leakage) @ both  # (..., l, k - l)
    place = (-apart).clip(-reach, reach) + reach  # (..., l, k)
    shape = np.broadcast_shapes(turned.shape[:-1], place.shape[:-1])
    spread = np.take_along_axis(
        np.broadcast_to(turned, (*shape, turned.shape[-1])),
        np.broadcast_to(place, (*shape, place.shape[-1])),
        axis=-1,
    ).swapaxes(-1, -2)
    damping = near.gap.imag
    back = spread.conj().swapaxes(-1, -2)
    power = (spread - back) / (-1j * (damping[..., :, None] + damping[..., None, :]))
    white = np.broadcast_to(_together(leakage, line), spread.shape)
    rows = [np.stack([power, back], axis=-1), np.stack([spread, white], axis=-1)]
    return np.stack(rows, axis=-2)


def _together(leakage: WindowLeakage, line: IntArray) -> ComplexArray:
    """Return the correlation of white noise in lines, (..., n_lines, n_lines)."""
    apart = line[..., :, None] - line[..., None, :]
    share = leakage.together[np.abs(apart).clip(max=len(leakage.together) - 1)]
    return np.asarray(np.where(apart < 0, share.conj(), share))


def _not_zero(values: ComplexArray) -> ComplexArray:
    return np.asarray(np.where(values == 0, 1, values))
