"""Random errors of averaged spectra and of their logarithms."""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from scipy.special import digamma, polygamma

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.numerics import COHERENCE_ROUNDING, SAFE_DIVISOR
from modallab.diagnosis.residuals.channel_spectra import ChannelSpectra
from modallab.diagnosis.residuals.settings import RANDOM_ERROR
from modallab.estimation.force_noise import ForceChannelNoise
from modallab.estimation.line_scatter import Estimate, estimated_error
from modallab.estimation.settings import FORCE_NOISE
from modallab.estimation.windows import WINDOWS
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.measurement import Measurement

RealOrComplex = TypeVar("RealOrComplex", FloatArray, ComplexArray)


def replace_zeros(array: RealOrComplex) -> RealOrComplex:
    """Return an array with 1 in place of 0, so that the logarithm of a line without data is finite."""
    return np.where(array != 0, array, np.ones_like(array))


def check_random_error_known(measurement: Measurement) -> None:
    """Raise unless the random error of every line is known.

    From coherence and averages, or as stated, or from the scatter of neighbouring lines.

    Raises
    ------
    InvalidInputError
        If there is no noise floor, and either too few averages to use the coherence, or neither a coherence
        nor enough lines.
    """
    if measurement.noise_floor is not None:
        return
    if measurement.coherence is None:
        values = np.asarray(measurement.frf.values, complex).reshape(len(measurement.frf.freq), -1)
        if scatter_error(values, measurement.setup.analyser.window) is not None:
            return
        raise InvalidInputError(
            "a diagnosis weighs residuals by their random error, and there are too few lines to estimate it: "
            "give the coherence and the number of averages, or else a noise floor",
            field="coherence",
            allowed="(n_freq, n_out), 0 to 1; or noise_floor, the relative random error of the FRFs",
        )
    further_forces = measurement.setup.n_simultaneous - 1
    if measurement.averages - further_forces <= RANDOM_ERROR.min_averages:
        least = RANDOM_ERROR.min_averages + further_forces
        raise InvalidInputError(
            "too few averages to know a random error from coherence: give a noise floor",
            field="averages",
            value=measurement.averages,
            allowed=f"> {least}; or noise_floor, the relative random error of the FRFs",
        )


def scatter_error(h: ComplexArray, window: str) -> tuple[Estimate, ...] | None:
    """Return the random error of FRFs (n_freq, n_out) over their median magnitude; None if lines are too few.

    (n_out,), from the scatter of neighbouring lines about a smooth local model.
    """
    return estimated_error(h[1:], WINDOWS[window])


def scale_error(measurement: Measurement, scatter: Sequence[Estimate] | None) -> float:
    """Return the relative standard error of the variances of FRFs, where these are estimated themselves.

    They go with 1/(n - 2) of the averages n, or with the square of the scatter of lines.
    """
    if scatter is not None:
        return 2 * float(np.median([e.standard_error / max(e.value, SAFE_DIVISOR) for e in scatter]))
    averages = measurement.averages - (measurement.setup.n_simultaneous - 1)
    if measurement.averages_error is None or averages <= RANDOM_ERROR.min_averages:
        return 0.0
    return measurement.averages_error / (averages - 2)


def coherence_and_variance(spectra: ChannelSpectra) -> tuple[FloatArray, FloatArray]:
    """Return the coherence, 1 where it is unknown, and the relative variance of |H| that follows from it.

    Both (n_freq, n_out). With n_in simultaneous forces the squared error of an FRF has the mean
    (1 - g2)/g2 over n - n_in - 1 averages, g2 the partial coherence: a complex t distribution.
    """
    g2, n = spectra.coherence, spectra.conditional_averages
    if g2 is None or n <= RANDOM_ERROR.min_averages:
        zeros = np.zeros(spectra.h.shape)
        return zeros + 1, zeros
    return g2, (1 - g2) / (2 * np.maximum(g2, FORCE_NOISE.min_coherence) * (n - 2))


def weak_line_factor(h: ComplexArray) -> FloatArray:
    """Return the median magnitude of each FRF over that of each line, (n_freq, n_out), at least 1.

    Noise is no smaller where a structure hardly moves: a stated relative error is that of the median line.
    """
    size = np.abs(h)
    return np.asarray(np.maximum(np.median(size, axis=0) / np.where(size > 0, size, np.inf), 1.0))


def incoherent_spectrum(
    spectra: ChannelSpectra, h: ComplexArray, variance_floor: float
) -> tuple[FloatArray | None, FloatArray | None]:
    """Return G_xx (1 - coherence) and the variance of its logarithm, both (n_freq, n_out).

    The expectation of the logarithm is unbiased. With several simultaneous forces the coherence is the
    multiple one, and equal for all FRFs of a response. Where no response spectrum is known, the spectrum
    follows from the FRF, the coherence and the force spectrum; without that it is the one over the force.

    Parameters
    ----------
    h
        (n_freq, n_out), H1.
    variance_floor
        Least variance of the logarithm.
    """
    g2, n = spectra.response_coherence, spectra.conditional_averages
    if g2 is None or n <= RANDOM_ERROR.min_averages:
        return None, None
    response = spectra.response
    if response is None:
        if spectra.n_simultaneous > 1 or not (g2 < 1 - COHERENCE_ROUNDING).any():
            return None, None
        force = 1.0 if spectra.force_by_channel is None else spectra.force_by_channel
        response = force * np.abs(h) ** 2 / np.maximum(g2, FORCE_NOISE.min_coherence)
    incoherent, floor = response * (1 - g2), COHERENCE_ROUNDING * response
    # Where rounding is the larger part, the logarithm has an error of order one.
    rounding = floor / (incoherent + floor + SAFE_DIVISOR)
    variance = polygamma(1, n - 1) * (1 - rounding) ** 2 + rounding**2 + variance_floor
    unbiased = incoherent * np.exp(np.log(spectra.averages) - digamma(n - 1))
    if spectra.response is None and spectra.force is None:
        repeats = EXCITATIONS[spectra.excitation.kind].deterministic
        gamma_shape, force_variance = _force_scatter(spectra, np.array(0.0 if repeats else 1.0))
        unbiased *= np.exp(digamma(gamma_shape) - np.log(gamma_shape))
        variance = variance + force_variance
    return replace_zeros(unbiased + floor), np.asarray(variance)


def force_spectrum(
    spectra: ChannelSpectra, variance_floor: float
) -> tuple[FloatArray | None, FloatArray | float]:
    """Return G_ff (n_freq, n_run), N^2/Hz, and the variance of its logarithm.

    The expectation of the logarithm is unbiased. If a share s of the power is random, G_ff has nearly a
    Gamma distribution of shape n/(s (2 - s)), n the number of averages: Patnaik (1949), Biometrika 36,
    202-232.

    Parameters
    ----------
    variance_floor
        Least variance of the logarithm.
    """
    if spectra.force is None:
        return None, 1.0
    force = replace_zeros(spectra.force)
    excitation = EXCITATIONS[spectra.excitation.kind]
    periodic = excitation.deterministic and spectra.coherence is not None
    random_share = _force_noise_bound(spectra) / force if periodic else np.ones_like(force)
    gamma_shape, variance = _force_scatter(spectra, random_share)
    return force * np.exp(np.log(gamma_shape) - digamma(gamma_shape)), np.asarray(variance + variance_floor)


def _force_scatter(spectra: ChannelSpectra, random_share: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the shape of the Gamma distribution of G_ff, and the variance of its logarithm.

    Parameters
    ----------
    random_share
        Share of its power that is random.
    """
    share = np.clip(random_share, RANDOM_ERROR.prediction_error**2, 1.0)
    # The sizes of blows scatter too, of all lines alike.
    blow_variance = np.exp(4 * spectra.excitation.level_scatter**2) - 1
    gamma_shape = spectra.averages / (share * (2 - share))
    return gamma_shape, np.asarray(polygamma(1, gamma_shape) + blow_variance / spectra.averages)


def shared_noise(spectra: ChannelSpectra) -> FloatArray | None:
    """Return the share of each FRF's random variance that the force's noise has, (n_freq, n_out).

    All channels of a run have that noise in common. None where each channel has a run of its own, or the
    spectra do not separate the two noises.
    """
    g2, force, response = spectra.coherence, spectra.force, spectra.response
    n_runs = spectra.channels[-1].run + 1
    if n_runs == len(spectra.channels) or spectra.averages <= RANDOM_ERROR.min_averages:
        return None
    if spectra.n_simultaneous > 1:
        return None
    if g2 is None or force is None or response is None:
        return None
    nonzero, runs = spectra.freq > 0, np.array([channel.run for channel in spectra.channels])
    share = np.zeros(g2.shape)
    for run in range(n_runs):
        in_run = runs == run
        g2_of_run, force_of_run = g2[:, in_run], replace_zeros(force[:, run, None])
        noise = ForceChannelNoise.of(nonzero, g2_of_run, force_of_run, response[:, in_run] * g2_of_run)
        if noise is not None:
            share[:, in_run] = noise.share
    return share if share.any() else None


def _force_noise_bound(spectra: ChannelSpectra) -> float:
    """Return an upper bound of the white noise in the force, N^2/Hz.

    Noise of the force lowers the coherence at every line; noise of a response lowers it only where that
    response is weak. So the lines of highest coherence bound the noise of the force.
    """
    force = spectra.force_by_channel
    assert force is not None
    assert spectra.coherence is not None
    incoherent = force * (1 - spectra.coherence)
    incoherent = incoherent[spectra.freq > 0]
    width = min(RANDOM_ERROR.noise_average, len(incoherent))
    total = np.cumsum(np.concatenate([np.zeros_like(incoherent[:1]), incoherent]), axis=0)
    means = (total[width:] - total[:-width]) / width
    return float(np.quantile(means, RANDOM_ERROR.noise_quantile, axis=0).min())
