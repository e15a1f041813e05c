"""A measurement as the fit sees it: logarithms, their random errors, what is held out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind
from modallab.diagnosis.residuals.random_error import (
    INCOHERENT,
    NUMERICAL,
    RealOrComplex,
    coherence_and_variance,
    force_spectrum,
    incoherent_spectrum,
    replace_zeros,
    shared_noise,
    weak_line_factor,
)
from modallab.estimation.coherence import coherence
from modallab.estimation.estimators.h1 import h1
from modallab.estimation.settings import FORCE_NOISE
from modallab.estimation.spectra import CrossSpectra
from modallab.estimation.windows import WINDOWS
from modallab.rig.measurement import Measurement
from modallab.rig.periodic_variance import VarianceFactors


def _side_by_side(runs: RealOrComplex) -> RealOrComplex:
    """Return the channels (n_run, n_freq, n_out) of all runs as (n_freq, n_run n_out)."""
    out: RealOrComplex = runs.swapaxes(0, 1).reshape(runs.shape[1], -1)
    return out


SimulatedDeviations = tuple[FloatArray, ComplexArray, FloatArray]  # of the three below, by test


@dataclass(frozen=True, eq=False)
class VarianceRatios:
    """Variances over those of averages of Gaussian records drawn anew, by line and channel."""

    force: FloatArray  # (n_freq, n_run) of ln G_ff
    frf: FloatArray  # (n_freq, n_out) of H1
    response: FloatArray  # (n_freq, n_out) of ln of the incoherent spectrum
    # How far off their expectation the three lie in some tests, (n_tests, ..), see `VarianceFactors`.
    tests: SimulatedDeviations | None = None

    @classmethod
    def of(cls, runs: VarianceFactors | None, spectra: CrossSpectra) -> "VarianceRatios":
        """Return the factors of all runs side by side; 1 where all is drawn anew."""
        if runs is None:
            nothing = np.ones(spectra.xx.shape)
            return cls(nothing[..., 0].T, *2 * (_side_by_side(nothing),))
        tests = None
        if runs.tests is not None:
            force, frf, response = runs.tests
            h = np.array([_side_by_side(one) for one in frf])
            tests = (force.swapaxes(1, 2), h, np.array([_side_by_side(one) for one in response]))
        return cls(runs.force.T, _side_by_side(runs.frf), _side_by_side(runs.response), tests)


@dataclass(frozen=True, eq=False)
class Predicted:
    """Expected spectra by response channel, as `Observed` holds the measured ones."""

    h: ComplexArray  # (n_freq, n_out) H1, inertance
    coherence: FloatArray  # (n_freq, n_out)
    force: FloatArray  # (n_freq, n_run) N^2/Hz
    incoherent: FloatArray  # (n_freq, n_out) G_xx (1 - coherence), floored at rounding
    # Where power leaks: by how much more the incoherent spectrum scatters than from independent records,
    # (n_freq, n_out), worked out when a gap is judged, as it costs more than the prediction itself.
    excess_variance: Callable[[], FloatArray] | None = None
    # Where signals come back in every average: how much less the spectra scatter; worked out as late.
    variance_ratios: Callable[[], VarianceRatios] | None = None
    lines_correlated: bool = False  # whether lines share random numbers beyond what a window mixes

    @classmethod
    def of(
        cls,
        spectra: CrossSpectra,
        excess: Callable[[], FloatArray] | None = None,
        steady: Callable[[], VarianceFactors | None] | None = None,
        *,
        lines_correlated: bool = False,
    ) -> "Predicted":
        """Return the channels of all runs side by side; `excess_variance` gives (n_run, n_freq, n_out)."""
        g2 = coherence(spectra)
        loose = spectra.xx * (1 - g2 + INCOHERENT)
        h: ComplexArray = h1(spectra)[..., 0].swapaxes(0, 1).reshape(len(spectra.freq), -1)
        return cls(
            h,
            _side_by_side(g2),
            spectra.ff[:, :, 0, 0].real.T,
            _side_by_side(loose),
            None if excess is None else lambda: _side_by_side(excess()),
            None if steady is None else lambda: VarianceRatios.of(steady(), spectra),
            lines_correlated,
        )


@dataclass(frozen=True, eq=False)
class Observed:
    """Measured H1, force and incoherent response spectra with the variance of their logarithms.

    By Bartlett's factors of the Wishart law the three are independent: G_ff is Gamma(n), H1 normal
    given G_ff, and the incoherent response spectrum Gamma(n - 1). Of a force that comes back in every
    average, G_ff varies by its noise alone, of which coherence tells at most how much there is.
    """

    freq: FloatArray
    outputs: tuple[Dof, ...]
    h: ComplexArray  # (n_freq, n_out)
    error: FloatArray  # (n_freq, n_out) random error of |H| and of its phase
    coherence: FloatArray
    force: FloatArray | None  # (n_freq, n_run), expectation of the logarithm made unbiased
    force_variance: FloatArray | float  # (n_freq, n_run) of its logarithm
    incoherent: FloatArray | None  # (n_freq, n_out)
    incoherent_variance: FloatArray | None
    usable: BoolArray  # (n_freq, n_out)
    held_out: BoolArray  # (n_out,)
    held_out_lines: BoolArray  # (n_freq,)
    correlation_length: float  # how many lines one independent line stands for
    bias: FloatArray | float = 0.0  # (n_freq, n_out) of ln |H|, weighed by its error
    averages: float = np.inf
    floor: float = NUMERICAL**2  # variance that the logarithm of an auto spectrum has in any case
    # (n_freq, n_out): share of an FRF's random variance that is the force's noise, the same in all channels.
    shared_noise: FloatArray | None = None

    @property
    def fitted(self) -> BoolArray:
        """(n_freq, n_out): what the fit may see."""
        return np.asarray(self.usable & ~self.held_out & ~self.held_out_lines[:, None])

    @property
    def held_out_mask(self) -> BoolArray:
        """(n_freq, n_out): what is held out."""
        return np.asarray(self.usable & ~self.fitted)

    def with_variance_ratios(self, factors: VarianceRatios) -> "Observed":
        """Return the same with variances that are so many times as large."""
        incoherent = self.incoherent_variance
        return replace(
            self,
            error=self.error * np.sqrt(factors.frf),
            force_variance=self.force_variance * factors.force,
            incoherent_variance=None if incoherent is None else incoherent * factors.response,
        )

    def decimated(self, step: int) -> "Observed":
        """Return every `step`-th line."""
        every = slice(None, None, step)
        return replace(
            self,
            freq=self.freq[every],
            h=self.h[every],
            error=self.error[every],
            bias=_every(self.bias, every),
            force_variance=_every(self.force_variance, every),
            coherence=self.coherence[every],
            force=None if self.force is None else self.force[every],
            incoherent=None if self.incoherent is None else self.incoherent[every],
            incoherent_variance=None if self.incoherent_variance is None else self.incoherent_variance[every],
            usable=self.usable[every],
            held_out_lines=self.held_out_lines[every],
            shared_noise=None if self.shared_noise is None else self.shared_noise[every],
        )


def _every(values: FloatArray | float, every: slice) -> FloatArray | float:
    return values if isinstance(values, float) else values[every]


def _on_the_axis(measurement: Measurement) -> Measurement:
    """Return a measurement that starts above 0 Hz with a line there of which nothing is known."""
    if measurement.frf.freq[0] == 0:
        return measurement
    return measurement.by_line(lambda array: np.concatenate([np.zeros_like(array[:1]), array]))


def observe(measurement: Measurement, held_out: Sequence[Dof], *, fraction: float) -> Observed:
    """Return what the fit sees of a measurement.

    Parameters
    ----------
    held_out
        Responses kept out of every fit; with none, every 1/fraction-th line is held out instead.

    Raises
    ------
    InvalidInputError
        If no random error is known, see `check_weighable`; or if no line is left to fit.
    """
    measurement = _on_the_axis(measurement.to(FrfKind.INERTANCE))
    g2, chance = coherence_and_variance(measurement)
    stated = measurement.noise_floor or 0.0
    analyser = measurement.setup.analyser
    frf, n = measurement.frf, measurement.averages
    # H1, whatever the estimator was: H2 = H1 / g2 and Hv = H1 / g.
    power = {"h1": 0.0, "h2": 1.0, "hv": 0.5}[analyser.estimator]
    h = frf.values[:, :, 0] * g2**power
    usable = (g2 > FORCE_NOISE.min_coherence) & (frf.freq > 0)[:, None] & (np.abs(h) > 0)
    error = np.sqrt(chance + (stated * weak_line_factor(h)) ** 2 + NUMERICAL**2)
    least = 4 * (stated**2 + NUMERICAL**2)  # power has twice the relative error of amplitude
    incoherent, spread = incoherent_spectrum(measurement, least)
    force, force_variance = force_spectrum(measurement, least)
    out = np.array([d.point in {h.point for h in held_out} for d in frf.outputs])
    lines = np.zeros(len(frf.freq), bool)
    if not out.any() and fraction > 0:
        lines[2 :: max(2, round(1 / fraction))] = True
    window = WINDOWS[analyser.window].samples(256) ** 2
    observed = Observed(
        freq=frf.freq,
        outputs=frf.outputs,
        h=replace_zeros(h),
        error=error,
        coherence=g2,
        force=force,
        force_variance=force_variance,
        incoherent=incoherent,
        incoherent_variance=spread,
        usable=usable,
        held_out=out,
        held_out_lines=lines,
        correlation_length=float((window**2).mean() / window.mean() ** 2),
        bias=2 * chance**2 / error**2,
        averages=n,
        floor=least,
        shared_noise=shared_noise(measurement),
    )
    _check_something_is_left(observed)
    return observed


def _check_something_is_left(observed: Observed) -> None:
    if not observed.usable.any():
        raise InvalidInputError(
            "no line shows a response",
            field="coherence",
            value=float(observed.coherence.max()),
            allowed=f"> {FORCE_NOISE.min_coherence:g}",
        )
    if not observed.fitted.any():
        held = [str(dof) for dof, out in zip(observed.outputs, observed.held_out, strict=True) if out]
        raise InvalidInputError(
            "with these held out nothing is left to fit", field="hold_out", value=", ".join(held)
        )
