"""Noise of the force channel: FRFs measured at once have it in common, and H1 is too small by it."""

from dataclasses import dataclass
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.estimation.settings import FORCE_NOISE

Numbers = TypeVar("Numbers", bound=NDArray[np.inexact[Any]])


@dataclass(frozen=True, eq=False)
class ForceChannelNoise:
    """White noise of the force as coherence tells it.

    1/g2 - 1 = r + P/(g2 G_xx), r the noise of the force over its signal, N/(G_ff - N), and P white noise
    of the response: the one is in all FRFs alike, the other the more the less a structure moves.
    """

    loose: FloatArray  # (n_freq, n_frf) G_ff (1/g2 - 1), median 1 of all lines above 0 Hz
    weaker: FloatArray  # (n_freq, n_frf) G_ff over coherent power of the response, of the order of 1
    force: FloatArray  # (n_freq, n_frf) or (n_freq, 1) G_ff, in units of `loose`
    above: BoolArray  # (n_freq,) lines above 0 Hz

    @classmethod
    def of(
        cls, above: BoolArray, coherence: FloatArray, force: FloatArray, heard: FloatArray
    ) -> "ForceChannelNoise | None":
        """Return what tells of it, None where there is no noise at all beyond rounding.

        Parameters
        ----------
        above
            (n_freq,) lines above 0 Hz.
        coherence
            (n_freq, n_frf).
        force
            (n_freq, n_frf) or (n_freq, 1) G_ff, N^2/Hz.
        heard
            (n_freq, n_frf) coherent power g2 G_xx of the motion whose noise is white.
        """
        loose = force * (1 - coherence) / np.maximum(coherence, FORCE_NOISE.min_coherence)
        weaker = np.median(heard[above]) / np.maximum(
            heard, FORCE_NOISE.min_coherence * np.median(heard[above])
        )
        weaker = weaker * force / np.median(force[above])
        size = float(np.median(loose[above]))
        if not size > FORCE_NOISE.relative_rounding**2 * float(np.median(force[above])):
            return None
        return cls(loose / size, weaker, force / size, above)

    @property
    def share(self) -> FloatArray:
        """(n_freq, n_frf) of each FRF's random variance that is the force's noise."""
        noise, own = _both_noises(self.loose[self.above], self.weaker[self.above])
        both = noise + own * self.weaker
        # A line's own power would let those weigh more that came out large by chance.
        every = np.where(self.loose > FORCE_NOISE.outlier_ratio * both, self.loose, both)
        return np.asarray(
            np.minimum(noise / np.maximum(every, FORCE_NOISE.min_coherence), FORCE_NOISE.max_common_fraction)
        )

    @property
    def rise(self) -> FloatArray:
        """(n_freq, n_frf) noise over the force without it: H = H1 (1 + rise)."""
        noise, _ = _both_noises(self.loose[self.above], self.weaker[self.above], self.force[self.above])
        return np.asarray(np.broadcast_to(noise / _signal(self.force, noise), self.loose.shape))


def _signal(force: FloatArray, noise: float) -> FloatArray:
    return np.asarray(
        np.maximum(force - noise, max(FORCE_NOISE.min_signal_to_noise * noise, np.finfo(float).tiny))
    )


def _both_noises(
    loose: FloatArray, weaker: FloatArray, force: FloatArray | None = None
) -> tuple[float, FloatArray]:
    """Return white noise of the force and of each response (n_frf,) that add up to incoherent power.

    Least squares of relative differences, alternating; lines on which there is more than both, as where
    power leaks, are left out. With the force, N G_ff/(G_ff - N) is fitted and not N, by Newton's steps.
    """
    noise, own = (
        float(np.quantile(loose, FORCE_NOISE.initial_quantile)),
        np.quantile(loose / weaker, FORCE_NOISE.initial_quantile, axis=0),
    )
    for _ in range(FORCE_NOISE.iterations):
        more = 1.0 if force is None else force / _signal(force, noise)
        both = noise * more + own * weaker + FORCE_NOISE.min_coherence
        weight = (loose < FORCE_NOISE.outlier_ratio * both) / both**2
        seen = np.maximum((weight * weaker**2).sum(axis=0), FORCE_NOISE.min_coherence)
        own = np.maximum((weight * weaker * (loose - noise * more)).sum(axis=0) / seen, 0.0)
        slope, left = more**2, loose - own * weaker - noise * more * (1 - more)
        total = max(float((weight * slope**2).sum()), FORCE_NOISE.min_coherence)
        noise = max(float((weight * slope * left).sum()) / total, 0.0)
    return noise, own


def parted(part: Numbers, share: FloatArray, where: BoolArray) -> Numbers:
    """Return residuals (n_lines, n_frf) that share a random number in each line, made independent.

    Their covariance D + v v^T, v^2 the shares and D the rest, has the inverse square root
    (I - (1 - 1/sqrt(1 + w^2)) w w^T/w^2) D^-1/2 with w = D^-1/2 v.

    Parameters
    ----------
    part
        (n_lines, n_frf), or with more axes behind, as share and where then have.
    share
        (n_lines, n_frf) of each one's variance that is the shared number's.
    where
        (n_lines, n_frf) those that are looked at together.
    """
    rest = np.sqrt(1 - share)
    along = np.where(where, np.sqrt(share) / rest, 0.0)
    size = (along**2).sum(axis=1, keepdims=True)
    alone = np.where(where, part / rest, 0.0)
    both = (along * alone).sum(axis=1, keepdims=True) / np.maximum(size, SAFE_DIVISOR)
    return cast(Numbers, alone - (1 - 1 / np.sqrt(1 + size)) * along * both)
