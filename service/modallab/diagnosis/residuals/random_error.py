"""How averages scatter: the random errors of what is measured, and of what they are logarithms."""

from typing import TypeVar

import numpy as np
from scipy.special import digamma, polygamma

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError
from modallab.estimation.force_noise import ForceChannelNoise
from modallab.estimation.settings import FORCE_NOISE
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.measurement import Measurement

NUMERICAL = 1e-6  # relative error of the prediction itself: a floor under every random error
INCOHERENT = 1e-8  # share of a response below which what is not coherent counts as rounding
SMOOTHED = 7  # lines that an estimate of noise is averaged over
LEAST = 0.1  # share of the lines from whose noise that of the force is estimated

RealOrComplex = TypeVar("RealOrComplex", FloatArray, ComplexArray)


def replace_zeros(array: RealOrComplex) -> RealOrComplex:
    """Return an array whose logarithm is a number at lines that nothing was seen at and none looks at."""
    return np.where(array != 0, array, np.ones_like(array))


def check_random_error_known(measurement: Measurement) -> None:
    """Raise unless the random error of every line is known: from coherence and averages, or as stated.

    Raises
    ------
    InvalidInputError
        If there is no coherence, or are too few averages for it to say anything, and no noise floor.
    """
    if measurement.noise_floor is not None:
        return
    if measurement.coherence is None:
        raise InvalidInputError(
            "a diagnosis weighs residuals by their random error: give the coherence and the number of "
            "averages, or else a noise floor",
            field="coherence",
            allowed="(n_freq, n_out), 0 to 1; or noise_floor, the relative random error of the FRFs",
        )
    if measurement.averages <= 2:
        raise InvalidInputError(
            "too few averages to know a random error from coherence: give a noise floor",
            field="averages",
            value=measurement.averages,
            allowed="> 2; or noise_floor, the relative random error of the FRFs",
        )


def coherence_and_variance(measurement: Measurement) -> tuple[FloatArray, FloatArray]:
    """Return coherence, 1 where it is not known, and the squared random error of |H| that it tells."""
    check_random_error_known(measurement)
    g2, n = measurement.coherence, measurement.averages
    if g2 is None or n <= 2:
        nothing = np.zeros(measurement.frf.values.shape[:2])
        return nothing + 1, nothing
    return g2, (1 - g2) / (2 * np.maximum(g2, FORCE_NOISE.min_coherence) * (n - 2))


def weak_line_factor(h: ComplexArray) -> FloatArray:
    """Return by how much each line (n_freq, n_out) is below the median of its FRF, at least 1.

    Noise is not smaller where a structure hardly moves: a stated error is of the median there.
    """
    size = np.abs(h)
    return np.asarray(np.maximum(np.median(size, axis=0) / np.where(size > 0, size, np.inf), 1.0))


def incoherent_spectrum(
    measurement: Measurement, least: float
) -> tuple[FloatArray | None, FloatArray | None]:
    """Return G_xx (1 - coherence), its logarithm's expectation made unbiased, and the variance of that.

    Parameters
    ----------
    least
        Variance that the logarithm has in any case.
    """
    spectrum, g2, n = measurement.response_spectrum, measurement.coherence, measurement.averages
    if spectrum is None or g2 is None or n <= 2:
        return None, None
    loose, floor = spectrum * (1 - g2), INCOHERENT * spectrum
    # Where rounding is the larger part, the logarithm says nothing: its error is of order one.
    rounding = floor / (loose + floor + 1e-300)
    spread = polygamma(1, n - 1) * (1 - rounding) ** 2 + rounding**2 + least
    return replace_zeros(loose * np.exp(np.log(n) - digamma(n - 1)) + floor), np.asarray(spread)


def force_spectrum(measurement: Measurement, least: float) -> tuple[FloatArray | None, FloatArray | float]:
    """Return G_ff (n_freq, n_run), its logarithm's expectation made unbiased, and the variance of that.

    `least` is what the variance is in any case. Of a random share s of its power, G_ff is nearly Gamma of
    n/(s (2 - s)): Patnaik (1949), Biometrika 36, 202-232.
    """
    runs = slice(None) if measurement.setup.accelerometers.roving else slice(0, 1)
    if measurement.force_spectrum is None:
        return None, 1.0
    force = replace_zeros(measurement.force_spectrum[:, runs, 0])
    excitation = EXCITATIONS[measurement.setup.analyser.excitation.kind]
    known = excitation.comes_back and measurement.coherence is not None
    share = _noise_of_force(measurement) / force if known else np.ones_like(force)
    share = np.clip(share, NUMERICAL**2, 1.0)
    # The sizes of blows scatter too, of all lines alike.
    sizes = np.exp(4 * measurement.setup.analyser.excitation.level_scatter**2) - 1
    worth = measurement.averages / (share * (2 - share))
    variance = polygamma(1, worth) + sizes / measurement.averages
    return force * np.exp(np.log(worth) - digamma(worth)), np.asarray(variance + least)


def shared_noise(measurement: Measurement) -> FloatArray | None:
    """Return the share of each FRF's random variance that is the force's noise, (n_freq, n_out).

    All channels of a run have that noise in common; None where each has a run of its own, or nothing
    tells how much it is.
    """
    g2, force = measurement.coherence, measurement.force_spectrum
    alone = measurement.setup.accelerometers.roving or measurement.frf.values.shape[1] < 2
    if alone or g2 is None or force is None or measurement.averages <= 2:
        return None
    response = measurement.response_spectrum
    if response is None:
        return None
    above = measurement.frf.freq > 0
    noise = ForceChannelNoise.of(above, g2, replace_zeros(force[:, :1, 0]), response * g2)
    return None if noise is None else noise.share


def _noise_of_force(measurement: Measurement) -> float:
    """Return at most how strong white noise in the force can be, N^2/Hz.

    Noise takes its share of the coherence at every line, noise of the response takes the rest: where
    responses are strongest, next to none.
    """
    assert measurement.force_spectrum is not None
    assert measurement.coherence is not None
    loose = measurement.force_spectrum[:, :, 0] * (1 - measurement.coherence)
    loose = loose[measurement.frf.freq > 0]
    near = min(SMOOTHED, len(loose))
    total = np.cumsum(np.concatenate([np.zeros_like(loose[:1]), loose]), axis=0)
    return float(np.quantile((total[near:] - total[:-near]) / near, LEAST, axis=0).min())
