"""Noise of the force channel: common to simultaneously measured FRFs, and a negative bias of H1."""

from dataclasses import dataclass
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.estimation.settings import FORCE_NOISE

Numbers = TypeVar("Numbers", bound=NDArray[np.inexact[Any]])


@dataclass(frozen=True, eq=False)
class ForceChannelNoise:
    """White noise of the force channel, estimated from the coherence.

    1/g2 - 1 = r + P/(g2 G_xx), r the noise of the force over its signal, N/(G_ff - N), and P white noise
    of the response: r is the same in all FRFs, the other term grows as the response falls.
    """

    incoherent: FloatArray  # (n_freq, n_frf) G_ff (1/g2 - 1), median 1 of all lines above 0 Hz
    power_ratio: FloatArray  # (n_freq, n_frf) G_ff over coherent power of the response, of the order of 1
    force: FloatArray  # (n_freq, n_frf) or (n_freq, 1) G_ff, in units of `incoherent`
    positive_lines: BoolArray  # (n_freq,) lines above 0 Hz

    @classmethod
    def of(
        cls, positive_lines: BoolArray, coherence: FloatArray, force: FloatArray, response_power: FloatArray
    ) -> "ForceChannelNoise | None":
        """Return the noise of the force channel, None without noise above rounding.

        Parameters
        ----------
        positive_lines
            (n_freq,) lines above 0 Hz.
        coherence
            (n_freq, n_frf).
        force
            (n_freq, n_frf) or (n_freq, 1) G_ff, N^2/Hz.
        response_power
            (n_freq, n_frf) coherent power g2 G_xx of the motion whose noise is white.
        """
        incoherent = force * (1 - coherence) / np.maximum(coherence, FORCE_NOISE.min_coherence)
        power_ratio = np.median(response_power[positive_lines]) / np.maximum(
            response_power, FORCE_NOISE.min_coherence * np.median(response_power[positive_lines])
        )
        power_ratio = power_ratio * force / np.median(force[positive_lines])
        size = float(np.median(incoherent[positive_lines]))
        if not size > FORCE_NOISE.relative_rounding**2 * float(np.median(force[positive_lines])):
            return None
        return cls(incoherent / size, power_ratio, force / size, positive_lines)

    @property
    def share(self) -> FloatArray:
        """(n_freq, n_frf) fraction of each FRF's random variance that is due to the force's noise."""
        lines = self.positive_lines
        noise, response_noise = _white_noises(self.incoherent[lines], self.power_ratio[lines])
        white_noise = noise + response_noise * self.power_ratio
        # Weights by a line's own power would favour lines whose power is low by chance.
        outliers = self.incoherent > FORCE_NOISE.outlier_ratio * white_noise
        total = np.where(outliers, self.incoherent, white_noise)
        share = noise / np.maximum(total, FORCE_NOISE.min_coherence)
        return np.asarray(np.minimum(share, FORCE_NOISE.max_common_fraction))

    @property
    def rise(self) -> FloatArray:
        """(n_freq, n_frf) noise over the force without it: H = H1 (1 + rise)."""
        noise, _ = _white_noises(
            self.incoherent[self.positive_lines],
            self.power_ratio[self.positive_lines],
            self.force[self.positive_lines],
        )
        return np.asarray(np.broadcast_to(noise / _signal(self.force, noise), self.incoherent.shape))


def _signal(force: FloatArray, noise: float) -> FloatArray:
    return np.asarray(
        np.maximum(force - noise, max(FORCE_NOISE.min_signal_to_noise * noise, np.finfo(float).tiny))
    )


def _white_noises(
    incoherent: FloatArray, power_ratio: FloatArray, force: FloatArray | None = None
) -> tuple[float, FloatArray]:
    """Return white noise of the force and of each response (n_frf,) that add up to incoherent power.

    Least squares of relative differences, alternating; lines on which there is more than both, as where
    power leaks, are left out. With the force, N G_ff/(G_ff - N) is fitted and not N, by Newton's steps.
    """
    quantile = FORCE_NOISE.initial_quantile
    noise = float(np.quantile(incoherent, quantile))
    response_noise = np.quantile(incoherent / power_ratio, quantile, axis=0)
    for _ in range(FORCE_NOISE.iterations):
        gain = 1.0 if force is None else force / _signal(force, noise)
        white_noise = noise * gain + response_noise * power_ratio + FORCE_NOISE.min_coherence
        weight = (incoherent < FORCE_NOISE.outlier_ratio * white_noise) / white_noise**2
        curvature = np.maximum((weight * power_ratio**2).sum(axis=0), FORCE_NOISE.min_coherence)
        response_noise = np.maximum(
            (weight * power_ratio * (incoherent - noise * gain)).sum(axis=0) / curvature, 0.0
        )
        slope, residual = gain**2, incoherent - response_noise * power_ratio - noise * gain * (1 - gain)
        total = max(float((weight * slope**2).sum()), FORCE_NOISE.min_coherence)
        noise = max(float((weight * slope * residual).sum()) / total, 0.0)
    return noise, response_noise


def decorrelated(part: Numbers, share: FloatArray, used: BoolArray) -> Numbers:
    """Return decorrelated residuals (n_lines, n_frf), which have a common random part at each line.

    Their covariance D + v v^T, v^2 the shares and D the rest, has the inverse square root
    (I - (1 - 1/sqrt(1 + w^2)) w w^T/w^2) D^-1/2 with w = D^-1/2 v.

    Parameters
    ----------
    part
        (n_lines, n_frf), or with more axes behind, as share and where then have.
    share
        (n_lines, n_frf) fraction of each variance due to the common part.
    used
        (n_lines, n_frf) residuals that are included.
    """
    independent = np.sqrt(1 - share)
    along = np.where(used, np.sqrt(share) / independent, 0.0)
    size = (along**2).sum(axis=1, keepdims=True)
    scaled = np.where(used, part / independent, 0.0)
    projection = (along * scaled).sum(axis=1, keepdims=True) / np.maximum(size, SAFE_DIVISOR)
    return cast(Numbers, scaled - (1 - 1 / np.sqrt(1 + size)) * along * projection)


def decorrelated_by_run(part: Numbers, share: FloatArray, used: BoolArray, runs: IntArray) -> Numbers:
    """Return residuals (n_lines, n_frf) with the random part that the FRFs of a run share decorrelated.

    Parameters
    ----------
    part, share, used
        As `decorrelated`.
    runs
        (n_frf,) number of each FRF's run, ascending.
    """
    first = np.unique(runs, return_index=True)[1]
    if len(first) == 1:
        return decorrelated(part, share, used)
    groups = [slice(i, j) for i, j in zip(first, [*first[1:], len(runs)], strict=True)]
    blocks = [decorrelated(part[:, g], share[:, g], used[:, g]) for g in groups]
    return cast(Numbers, np.concatenate(blocks, axis=1))
