"""A measurement as a fit sees it: spectra, their random errors, the data held out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind
from modallab.diagnosis.residuals.predicted import VarianceRatios
from modallab.diagnosis.residuals.random_error import (
    coherence_and_variance,
    force_spectrum,
    incoherent_spectrum,
    replace_zeros,
    shared_noise,
    weak_line_factor,
)
from modallab.diagnosis.residuals.settings import RANDOM_ERROR
from modallab.estimation.settings import FORCE_NOISE
from modallab.estimation.windows import WINDOWS
from modallab.rig.measurement import Measurement


@dataclass(frozen=True, eq=False)
class Observed:
    """Measured H1, force and incoherent response spectra with the variance of their logarithms.

    By Bartlett's factorisation of the Wishart distribution the three are independent: G_ff has a
    Gamma(n) distribution, H1 given G_ff a normal one, the incoherent response spectrum Gamma(n - 1). If
    the force repeats in every average, G_ff varies by its noise alone, which coherence bounds from above.
    """

    freq: FloatArray
    """(n_freq,) Hz."""
    outputs: tuple[Dof, ...]
    """Responses, n_out of them."""
    h: ComplexArray
    """(n_freq, n_out) H1 as inertance, 1/kg."""
    error: FloatArray
    """(n_freq, n_out) relative random error of |H|, and of its phase in rad."""
    coherence: FloatArray
    """(n_freq, n_out), 1 where it is unknown."""
    force: FloatArray | None
    """(n_freq, n_run), N^2/Hz, the expectation of its logarithm unbiased."""
    force_variance: FloatArray | float
    """(n_freq, n_run), variance of the logarithm of `force`."""
    incoherent: FloatArray | None
    """(n_freq, n_out), (m/s^2)^2/Hz, response spectrum times 1 - coherence."""
    incoherent_variance: FloatArray | None
    """(n_freq, n_out), variance of its logarithm."""
    usable: BoolArray
    """(n_freq, n_out), entries with enough coherence."""
    held_out: BoolArray
    """(n_out,), responses excluded from every fit."""
    held_out_lines: BoolArray
    """(n_freq,), lines excluded from every fit."""
    correlation_length: float
    """Lines per independent line, by the window."""
    bias: FloatArray | float = 0.0
    """(n_freq, n_out), bias of ln |H| when weighted by its measured error."""
    averages: float = np.inf
    """Effective number of averages."""
    variance_floor: float = RANDOM_ERROR.prediction_error**2
    """Least variance of the logarithm of an auto spectrum."""
    shared_noise: FloatArray | None = None
    """(n_freq, n_out), share of an FRF's variance that the force's noise has, common to all channels."""

    @property
    def fitted(self) -> BoolArray:
        """(n_freq, n_out): entries that a fit may use."""
        return np.asarray(self.usable & ~self.held_out & ~self.held_out_lines[:, None])

    @property
    def held_out_mask(self) -> BoolArray:
        """(n_freq, n_out): usable entries that are held out."""
        return np.asarray(self.usable & ~self.fitted)

    def with_variance_ratios(self, ratios: VarianceRatios) -> "Observed":
        """Return the measurement with its variances multiplied by ratios."""
        incoherent = self.incoherent_variance
        return replace(
            self,
            error=self.error * np.sqrt(ratios.frf),
            force_variance=self.force_variance * ratios.force,
            incoherent_variance=None if incoherent is None else incoherent * ratios.response,
        )

    def decimated(self, step: int) -> "Observed":
        """Return every `step`-th line."""
        lines = slice(None, None, step)
        return replace(
            self,
            freq=self.freq[lines],
            h=self.h[lines],
            error=self.error[lines],
            bias=self.bias if isinstance(self.bias, float) else self.bias[lines],
            force_variance=self._force_variance_at(lines),
            coherence=self.coherence[lines],
            force=_rows(self.force, lines),
            incoherent=_rows(self.incoherent, lines),
            incoherent_variance=_rows(self.incoherent_variance, lines),
            usable=self.usable[lines],
            held_out_lines=self.held_out_lines[lines],
            shared_noise=_rows(self.shared_noise, lines),
        )

    def _force_variance_at(self, lines: slice) -> FloatArray | float:
        variance = self.force_variance
        return variance if isinstance(variance, float) else variance[lines]


def _rows(array: FloatArray | None, lines: slice) -> FloatArray | None:
    return None if array is None else array[lines]


def _from_zero_frequency(measurement: Measurement) -> Measurement:
    """Return a measurement with an unusable line at 0 Hz, where its frequency axis starts above it."""
    if measurement.frf.freq[0] == 0:
        return measurement
    return measurement.by_line(lambda array: np.concatenate([np.zeros_like(array[:1]), array]))


def observe(measurement: Measurement, held_out: Sequence[Dof], *, fraction: float) -> Observed:
    """Return the measured spectra, their random errors and the split into fitted and held-out data.

    Parameters
    ----------
    held_out
        Responses excluded from every fit; with none, every 1/fraction-th line is held out instead.

    Raises
    ------
    InvalidInputError
        If no random error is known, see `check_random_error_known`; or if no line is left to fit.
    """
    measurement = _from_zero_frequency(measurement.to(FrfKind.INERTANCE))
    g2, coherence_variance = coherence_and_variance(measurement)
    noise_floor = measurement.noise_floor or 0.0
    analyser, frf = measurement.setup.analyser, measurement.frf
    # H1, whatever the estimator was: H2 = H1 / g2 and Hv = H1 / g.
    power = {"h1": 0.0, "h2": 1.0, "hv": 0.5}[analyser.estimator]
    h = frf.values[:, :, 0] * g2**power
    prediction_error = RANDOM_ERROR.prediction_error
    error = np.sqrt(coherence_variance + (noise_floor * weak_line_factor(h)) ** 2 + prediction_error**2)
    # Power has twice the relative error of amplitude.
    variance_floor = 4 * (noise_floor**2 + prediction_error**2)
    incoherent, incoherent_variance = incoherent_spectrum(measurement, variance_floor)
    force, force_variance = force_spectrum(measurement, variance_floor)
    channels, lines = _held_out(measurement, held_out, fraction)
    window = WINDOWS[analyser.window].samples(RANDOM_ERROR.window_samples) ** 2
    observed = Observed(
        freq=frf.freq,
        outputs=frf.outputs,
        h=replace_zeros(h),
        error=error,
        coherence=g2,
        force=force,
        force_variance=force_variance,
        incoherent=incoherent,
        incoherent_variance=incoherent_variance,
        usable=(g2 > FORCE_NOISE.min_coherence) & (frf.freq > 0)[:, None] & (np.abs(h) > 0),
        held_out=channels,
        held_out_lines=lines,
        correlation_length=float((window**2).mean() / window.mean() ** 2),
        bias=2 * coherence_variance**2 / error**2,
        averages=measurement.averages,
        variance_floor=variance_floor,
        shared_noise=shared_noise(measurement),
    )
    _check_fittable(observed)
    return observed


def _held_out(
    measurement: Measurement, held_out: Sequence[Dof], fraction: float
) -> tuple[BoolArray, BoolArray]:
    """Return the held-out responses (n_out,) and lines (n_freq,)."""
    frf = measurement.frf
    points = {dof.point for dof in held_out}
    channels = np.array([dof.point in points for dof in frf.outputs])
    lines = np.zeros(len(frf.freq), bool)
    if not channels.any() and fraction > 0:
        lines[2 :: max(2, round(1 / fraction))] = True
    return channels, lines


def _check_fittable(observed: Observed) -> None:
    if not observed.usable.any():
        raise InvalidInputError(
            "no line shows a response",
            field="coherence",
            value=float(observed.coherence.max()),
            allowed=bounds(exclusive_minimum=FORCE_NOISE.min_coherence),
        )
    if not observed.fitted.any():
        responses = [str(dof) for dof, out in zip(observed.outputs, observed.held_out, strict=True) if out]
        raise InvalidInputError(
            "with these held out nothing is left to fit", field="hold_out", value=list(responses)
        )
