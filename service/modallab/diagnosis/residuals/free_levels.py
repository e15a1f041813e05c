"""Levels that no log book declares: fitted to the measured spectra in every prediction.

Spectrum of the source and noise of the channels are nuisance parameters of the force spectra and of the
incoherent response spectra. They are eliminated by variable projection (Golub and Pereyra, Inverse
Problems 19 (2003), R1-R26): each prediction has the levels that fit best beside it.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.numerics import COHERENCE_ROUNDING, SAFE_DIVISOR
from modallab.diagnosis.residuals.channel_noise import ChannelNoise, NoiseData
from modallab.diagnosis.residuals.h1_bias import share_of_bias
from modallab.diagnosis.residuals.noise_fit import fit_channel_noise
from modallab.diagnosis.residuals.noise_reference import ExpectedForceNoise, IncoherentSpectra
from modallab.diagnosis.residuals.settings import FREE_LEVELS
from modallab.diagnosis.residuals.source_power import force_spectra
from modallab.estimation.coherence import incoherent_ratio
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.frf_channel import stands_for_response
from modallab.rig.setup import RigSetup

if TYPE_CHECKING:
    from modallab.diagnosis.residuals.observed import Observed


@dataclass(frozen=True)
class FreeLevels:
    """Levels of a test that its log book leaves open."""

    source: bool = False
    """Level of the source."""
    shape: bool = False
    """Shape of its spectrum, a smooth curve."""
    force_noise: bool = False
    """Noise of the force channels, one smooth spectrum."""
    response_noise: bool = False
    """Noise of the response channels, a smooth spectrum each."""
    noise_reference: bool = False
    """To which force the ratio of its noise relates: the one measured, or the one expected."""
    expected_force_noise: ExpectedForceNoise | None = None
    """Noise at that ratio to the expected force; None if the ratio is to the one measured."""

    @classmethod
    def of(cls, setup: RigSetup, *, simulated: bool) -> "FreeLevels":
        """Return the levels that a log book leaves open.

        Parameters
        ----------
        simulated
            Whether the test was made here, where ratios of noise are to the force that was measured.
        """
        excitation, noise = setup.analyser.excitation, setup.noise
        free_shape = excitation.shape == "unknown"
        levels = cls(
            excitation.level is None or free_shape, free_shape, noise.force is None, noise.response is None
        )
        one_force = setup.n_simultaneous == 1 and noise.force_ratio > 0
        unclear = not simulated and one_force and not (levels.source or levels.noise)
        return replace(levels, noise_reference=unclear)

    def at(self, lines: IntArray) -> "FreeLevels":
        """Return the levels at some of the measured lines, (n,) indices."""
        noise = self.expected_force_noise
        return self if noise is None else replace(self, expected_force_noise=noise.at(lines))

    @property
    def noise(self) -> bool:
        """Whether noise of either side is open."""
        return self.force_noise or self.response_noise

    def fitted(
        self,
        spectra: CrossSpectra,
        observed: "Observed",
        lines: IntArray | None = None,
        *,
        start: ChannelNoise | None = None,
        last_step: float = FREE_LEVELS.last_step,
    ) -> CrossSpectra:
        """Return expected spectra with the levels that fit the measured ones best.

        Parameters
        ----------
        spectra
            For the levels of the log book; of what is open, none.
        lines
            (n,) indices of the measured lines among those of the spectra; None: all.
        start
            Noise of a prediction very much like this one, if it is known.
        last_step
            As in `fit_channel_noise`.
        """
        if self.expected_force_noise is not None:
            return self._with_force_noise(spectra, self.expected_force_noise, observed, lines)
        if not (self.source or self.noise):
            return spectra
        spectra = self.with_source(spectra, observed, lines)
        levels = self.fitted_noise(spectra, observed, lines, start=start, last_step=last_step)
        return spectra if levels is None else self._with_noise(spectra, levels, observed, lines)

    def with_source(
        self, spectra: CrossSpectra, observed: "Observed", lines: IntArray | None = None
    ) -> CrossSpectra:
        """Return expected spectra with the power of the sources that fits the measured ones best."""
        power = observed.source_power if self.source else None
        return spectra if power is None else power.applied(spectra, lines)

    def fitted_noise(
        self,
        spectra: CrossSpectra,
        observed: "Observed",
        lines: IntArray | None = None,
        *,
        start: ChannelNoise | None = None,
        last_step: float = FREE_LEVELS.last_step,
    ) -> ChannelNoise | None:
        """Return the noise levels that fit the measured incoherent spectra best.

        None if all levels are declared, or the spectra do not determine them.

        Parameters
        ----------
        spectra, lines, start, last_step
            As in `fitted`, with the level of the source.
        """
        if not self.noise:
            return None
        if lines is not None:
            spectra = spectra.at(lines)
        force, gain, coherent, other = _coherent_parts(spectra)
        measured, variance = _incoherent(observed, force[..., 0])
        if measured is None or variance is None:
            return None
        once = stands_for_response(observed.channels)
        return fit_channel_noise(
            NoiseData(
                freq=observed.freq,
                measured=measured[:, once],
                weight=(observed.usable & ~observed.held_out_lines[:, None])[:, once] / variance[:, once],
                fitted=observed.fitted[:, once],
                other=other,
                coherent=coherent,
                gain=gain,
                force=force,
            ),
            force_noise=self.force_noise,
            response_noise=self.response_noise,
            start=start,
            last_step=last_step,
        )

    def _with_noise(
        self, spectra: CrossSpectra, noise: ChannelNoise, observed: "Observed", lines: IntArray | None
    ) -> CrossSpectra:
        """Return spectra with noise; of free noise of the force only the share that the FRFs show biases H1.

        The rest is noise in proportion to the responses.
        """
        n_run, n_freq, n_out = spectra.xx.shape
        of_response, ff = noise.response_at(spectra.freq), spectra.ff
        if noise.force is not None:
            of_force = noise.force_at(spectra.freq)[:, None]
            ratio = of_force / np.maximum(force_spectra(spectra), SAFE_DIVISOR)
            at_lines = (spectra, ratio) if lines is None else (spectra.at(lines), ratio[:, lines])
            share = share_of_bias(*at_lines, observed)
            force, gain, _, _ = _coherent_parts(spectra)
            unbiased = ratio / (1 + ratio) - share * ratio / (1 + share * ratio)
            of_response = of_response + _proportional_noise(gain * force, unbiased)
            ff = ff + share * of_force[..., None] * np.eye(ff.shape[2])
        by_run = np.broadcast_to(of_response, (n_freq, n_run * n_out)).reshape(n_freq, n_run, n_out)
        return replace(spectra, ff=ff, xx=spectra.xx + by_run.swapaxes(0, 1))

    @staticmethod
    def _with_force_noise(
        spectra: CrossSpectra,
        expected_noise: ExpectedForceNoise,
        observed: "Observed",
        lines: IntArray | None,
    ) -> CrossSpectra:
        """Return expected spectra with noise of the force between both readings of its ratio."""
        at_lines = spectra if lines is None else spectra.at(lines)
        excess = expected_noise.excess(at_lines)
        if excess is None:
            return spectra
        force, _, coherent, other = _coherent_parts(at_lines)
        measured, variance = _incoherent(observed, force[..., 0])
        if measured is None or variance is None:
            return spectra
        incoherent = IncoherentSpectra(measured, observed.fitted / variance, other, coherent)
        n_out = coherent.shape[1] // len(excess)
        share = incoherent.fitted_share(np.repeat(excess, n_out) / force[..., 0])
        changed = spectra.ff + share * excess[:, None, None, None]
        # Lines that do not represent the mean of the band tell the noise at drop-outs approximately.
        return replace(spectra, ff=np.maximum(changed.real, expected_noise.noise[:, None, None, None]))


ALL_DECLARED = FreeLevels()


def _coherent_parts(spectra: CrossSpectra) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return forces and squared FRFs by response, (n_freq, n_run n_out, n_in), and both parts of responses.

    The auto spectra (n_freq, n_run n_out) of what is coherent with the forces, and of what is not.
    """
    n_run, n_freq, n_in, n_out = spectra.fx.shape
    force = np.repeat(force_spectra(spectra).swapaxes(0, 1), n_out, axis=1)
    if n_in == 1:
        cross = spectra.fx[:, :, 0].swapaxes(0, 1).reshape(n_freq, -1)
        coherent = np.abs(cross) ** 2 / force[..., 0]
        gain = (coherent / force[..., 0])[..., None]
    else:
        h = np.linalg.solve(spectra.ff, spectra.fx)
        coherent = (spectra.fx.conj() * h).sum(axis=2).real.swapaxes(0, 1).reshape(n_freq, -1)
        gain = (np.abs(h) ** 2).transpose(1, 0, 3, 2).reshape(n_freq, n_run * n_out, n_in)
    power = spectra.xx.swapaxes(0, 1).reshape(coherent.shape)
    return force, gain, coherent, np.maximum(power - coherent, COHERENCE_ROUNDING * power)


def _incoherent(observed: "Observed", force: FloatArray) -> tuple[FloatArray | None, FloatArray | None]:
    """Return incoherent response spectra (n_freq, n_out) and the variance of their logarithms.

    Without response spectra those that follow from coherence and FRFs at the expected force.

    Parameters
    ----------
    force
        (n_freq, n) expected spectrum of the first force, by response.
    """
    if observed.incoherent is not None:
        incoherent = observed.incoherent * force if observed.per_force else observed.incoherent
        return incoherent, observed.incoherent_variance
    g2 = observed.coherence
    if not (g2[observed.usable] < 1 - COHERENCE_ROUNDING).any() or not np.isfinite(observed.averages):
        return None, None
    by_frf = force if force.shape == g2.shape else np.tile(force, observed.n_simultaneous)
    variance = 1 / max(observed.conditional_averages - 1, 1.0)
    return by_frf * np.abs(observed.h) ** 2 * incoherent_ratio(g2), np.full(g2.shape, variance)


def _proportional_noise(by_force: FloatArray, ratio: FloatArray) -> FloatArray:
    """Return noise (n_freq, n_run n_out) of responses, in proportion to their parts by force.

    Parameters
    ----------
    by_force
        (n_freq, n_run n_out, n_in), parts of the responses that each force makes.
    ratio
        (n_run, n_freq, n_in), noise over these parts.
    """
    n_out = by_force.shape[1] // len(ratio)
    return np.asarray((by_force * np.repeat(ratio.swapaxes(0, 1), n_out, axis=1)).sum(axis=2))


def at_level_of(expected: CrossSpectra, fitted: CrossSpectra) -> CrossSpectra:
    """Return fitted spectra over the power of their source, with the fitted noise to the same scale.

    Shares of signal and noise are then those of the fit, beside signals of the level of `expected`.

    Parameters
    ----------
    expected, fitted
        Spectra before and after `FreeLevels.fitted`, of one force a run.
    """
    if fitted is expected:
        return expected
    # Noise adds to auto spectra alone: the cross spectra tell the power.
    size, unit = (np.abs(spectra.fx[:, :, 0]).sum(axis=2) for spectra in (fitted, expected))
    power = np.where((size > 0) & (unit > 0), size, 1.0) / np.where((size > 0) & (unit > 0), unit, 1.0)
    return replace(
        fitted,
        ff=fitted.ff / power[:, :, None, None],
        fx=fitted.fx / power[:, :, None, None],
        xx=fitted.xx / power[:, :, None],
    )
