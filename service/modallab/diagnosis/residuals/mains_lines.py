"""Lines of the mains: hum in force and response does not average out of an FRF."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.numerics import SAFE_DIVISOR
from modallab.diagnosis.residuals.channel_spectra import ChannelSpectra
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.settings import MAINS_LINES
from modallab.estimation.coherence import incoherent_ratio
from modallab.rig.analyser import Analyser
from modallab.rig.frf_channel import force_numbers


def with_mains_errors(observed: Observed, analyser: Analyser, spectra: ChannelSpectra) -> Observed:
    """Return a measurement with the errors that mains hum gives its lines, where responses show hum.

    Hum of both channels has a constant phase between them, so that it adds to G_fx what no average removes
    and no coherence tells; how much, nobody knows who has not measured with the source off. Of the
    response's hum a share as large as that of the force's counts as coherent.
    """
    shares = force_shares(analyser, spectra)
    if not shares.any():
        return observed
    variance = np.log1p(-shares) ** 2
    force_variance, incoherent = observed.force_variance, observed.incoherent_variance
    if observed.force is not None:
        of_force = np.zeros(observed.force.shape)
        np.maximum.at(of_force.T, observed.forces, variance.T)
        force_variance = force_variance + of_force
    return replace(
        observed,
        error=np.hypot(observed.error, np.where(shares > 0, MAINS_LINES.frf_error, 0.0)),
        force_variance=force_variance,
        incoherent_variance=None if incoherent is None else incoherent + variance,
    )


def force_shares(analyser: Analyser, spectra: ChannelSpectra) -> FloatArray:
    """Return the share of the force's power that may be hum, (n_freq, n_out); 0 where no response hums.

    A response hums where its incoherent power stands out of that of the lines beside, at the mains
    frequency and at the multiple of it.
    """
    shares = np.zeros(spectra.h.shape)
    for sine, hums in _loud_sines(analyser, spectra):
        loud = sine.lines[:, None] & hums
        shares = np.where(loud, np.maximum(shares, sine.force_share(spectra)), shares)
    return shares


def hum_frequencies(analyser: Analyser, spectra: ChannelSpectra) -> dict[float, int]:
    """Return the mains frequency and its multiples at which responses hum, Hz, with how many of them do."""
    return {sine.frequency: int(hums.sum()) for sine, hums in _loud_sines(analyser, spectra)}


def _loud_sines(analyser: Analyser, spectra: ChannelSpectra) -> "Iterator[tuple[_Sine, BoolArray]]":
    """Yield the sines that stand out of the incoherent power of responses (n_out,), with these."""
    noise = _incoherent_power(spectra)
    for mains in MAINS_LINES.frequencies if noise is not None else ():
        orders = range(1, MAINS_LINES.max_order + 1)
        sines = [_Sine.of(spectra.freq, order, mains, analyser) for order in orders]
        if noise is None or sines[0] is None:
            continue
        hums = sines[0].is_loud(noise)
        for sine in sines:
            if sine is not None and (loud := hums & sine.is_loud(noise)).any():
                yield sine, loud


def _incoherent_power(spectra: ChannelSpectra) -> FloatArray | None:
    """Return the part of each response's power that no force explains, (n_freq, n_out), in any unit."""
    if spectra.response_coherence is None:
        return None
    g2 = spectra.response_coherence
    if spectra.response is not None:
        return np.asarray(spectra.response * (1 - g2))
    return np.asarray(np.abs(spectra.h) ** 2 * incoherent_ratio(g2))


@dataclass(frozen=True, eq=False)
class _Sine:
    """A sine among the lines of an analyser."""

    frequency: float
    """Hz."""
    lines: BoolArray
    """(n_freq,) lines to which the window carries it."""
    beside: BoolArray
    """(n_freq,) lines that tell the level without it."""

    @classmethod
    def of(cls, freq: FloatArray, order: int, mains: float, analyser: Analyser) -> "_Sine | None":
        """Return a harmonic of the mains; None where it cannot show.

        It cannot outside the lines, nor where they are too few between two harmonics.
        """
        reach = max(len(analyser.line_window.coefficients) - 1, 1)
        distance = np.abs(freq - order * mains) / analyser.spacing
        farthest = min(reach + MAINS_LINES.lines_beside, mains / analyser.spacing / 2)
        lines = distance < reach + MAINS_LINES.tolerance
        beside = (distance > reach + 1) & (distance < farthest)
        enough = lines.any() and beside.sum() >= MAINS_LINES.least_beside
        return cls(order * mains, lines, beside) if enough else None

    def _ratio(self, power: FloatArray) -> FloatArray:
        """Return the largest power (n,) of its lines over the median of those beside."""
        level = np.median(power[self.beside], axis=0)
        return np.asarray(power[self.lines].max(axis=0) / (level + SAFE_DIVISOR))

    def is_loud(self, noise: FloatArray) -> BoolArray:
        """Return whether it stands out of noise (n_freq, n_out) in each channel, (n_out,)."""
        return np.asarray(self._ratio(noise) > MAINS_LINES.least_ratio)

    def force_share(self, spectra: ChannelSpectra) -> FloatArray | float:
        """Return the largest share (n_out,) that it may have in the power of a force of the run."""
        if spectra.force is None:
            return MAINS_LINES.unknown_share
        by_chance = 1 / np.sqrt(spectra.averages)
        share = 1 - 1 / np.maximum(self._ratio(spectra.force), 1.0) + by_chance
        runs = np.array([channel.run for channel in spectra.channels])
        largest = np.zeros(runs.max() + 1)
        np.maximum.at(largest, runs, share[force_numbers(spectra.channels)])
        return np.asarray(np.minimum(largest[runs], MAINS_LINES.largest_share))
