"""A measurement as the fit sees it: logarithms, their random errors, what is held out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from scipy.special import digamma, polygamma

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind
from modallab.estimation.coherence import coherence
from modallab.estimation.estimators.h1 import h1
from modallab.estimation.spectra import CrossSpectra
from modallab.estimation.windows import WINDOWS
from modallab.rig.measurement import Measurement

NUMERICAL = 1e-6  # relative error of the prediction itself: a floor under every random error
INCOHERENT = 1e-8  # share of a response below which what is not coherent counts as rounding
FAINT = 1e-6  # coherence below which there is no response at all
USABLE = 0.3  # coherence below which the logarithm of an FRF is no longer near normal

Numbers = TypeVar("Numbers", FloatArray, ComplexArray)


@dataclass(frozen=True, eq=False)
class Predicted:
    """Expected spectra by response channel, as `Observed` holds the measured ones."""

    h: ComplexArray  # (n_freq, n_out) H1, inertance
    coherence: FloatArray  # (n_freq, n_out)
    force: FloatArray  # (n_freq, n_run) N^2/Hz
    incoherent: FloatArray  # (n_freq, n_out) G_xx (1 - coherence), floored at rounding
    # Where power leaks: by how much more the incoherent spectrum scatters than from independent records,
    # (n_freq, n_out), worked out when a gap is judged, as it costs more than the prediction itself.
    excess: Callable[[], FloatArray] | None = None

    @classmethod
    def of(cls, spectra: CrossSpectra, excess: Callable[[], FloatArray] | None = None) -> "Predicted":
        """Return the channels of all runs side by side; `excess` gives (n_run, n_freq, n_out)."""
        n_run, n_freq, n_out = spectra.xx.shape
        g2 = coherence(spectra)
        loose = spectra.xx * (1 - g2 + INCOHERENT)

        def flat(values: FloatArray) -> FloatArray:
            return values.swapaxes(0, 1).reshape(n_freq, n_run * n_out)

        h: ComplexArray = h1(spectra)[..., 0].swapaxes(0, 1).reshape(n_freq, n_run * n_out)
        later = None if excess is None else lambda: flat(excess())
        return cls(h, flat(g2), spectra.ff[:, :, 0, 0].real.T, flat(loose), later)


@dataclass(frozen=True, eq=False)
class Observed:
    """Measured H1, force and incoherent response spectra with the variance of their logarithms.

    By Bartlett's factors of the Wishart law the three are independent: G_ff is Gamma(n), H1 normal
    given G_ff, and the incoherent response spectrum Gamma(n - 1).
    """

    freq: FloatArray
    outputs: tuple[Dof, ...]
    h: ComplexArray  # (n_freq, n_out)
    error: FloatArray  # (n_freq, n_out) random error of |H| and of its phase
    coherence: FloatArray
    force: FloatArray | None  # (n_freq, n_run), expectation of the logarithm made unbiased
    force_variance: float
    incoherent: FloatArray | None  # (n_freq, n_out)
    incoherent_variance: FloatArray | None
    usable: BoolArray  # (n_freq, n_out)
    held_out: BoolArray  # (n_out,)
    held_lines: BoolArray  # (n_freq,)
    correlation: float  # how many lines one independent line stands for

    @property
    def fitted(self) -> BoolArray:
        """(n_freq, n_out): what the fit may see."""
        return np.asarray(self.usable & ~self.held_out & ~self.held_lines[:, None])

    @property
    def kept(self) -> BoolArray:
        """(n_freq, n_out): what is held out."""
        return np.asarray(self.usable & ~self.fitted)

    def thinned(self, step: int) -> "Observed":
        """Return every `step`-th line."""
        every = slice(None, None, step)
        return replace(
            self,
            freq=self.freq[every],
            h=self.h[every],
            error=self.error[every],
            coherence=self.coherence[every],
            force=None if self.force is None else self.force[every],
            incoherent=None if self.incoherent is None else self.incoherent[every],
            incoherent_variance=None if self.incoherent_variance is None else self.incoherent_variance[every],
            usable=self.usable[every],
            held_lines=self.held_lines[every],
        )


def _weighable(measurement: Measurement) -> FloatArray:
    """Return the coherence of a measurement whose random error it and the averages tell."""
    if measurement.coherence is None:
        raise InvalidInputError(
            "a diagnosis weighs residuals by their random error: give the coherence and the averages",
            field="coherence",
            allowed="(n_freq, n_out), 0 to 1",
        )
    if measurement.averages <= 2:
        raise InvalidInputError(
            "too few averages to know a random error",
            field="averages",
            value=measurement.averages,
            allowed="> 2",
        )
    return measurement.coherence


def _on_the_axis(measurement: Measurement) -> Measurement:
    """Return a measurement that starts above 0 Hz with a line there of which nothing is known."""
    if measurement.frf.freq[0] == 0:
        return measurement
    return measurement.by_line(lambda array: np.concatenate([np.zeros_like(array[:1]), array]))


def _nowhere_zero(array: Numbers) -> Numbers:
    """Return an array whose logarithm is a number at lines that nothing was seen at and none looks at."""
    return np.where(array != 0, array, np.ones_like(array))


def observe(measurement: Measurement, held_out: Sequence[Dof], *, fraction: float) -> Observed:
    """Return what the fit sees of a measurement.

    Parameters
    ----------
    held_out
        Responses kept out of every fit; with none, every 1/fraction-th line is held out instead.

    Raises
    ------
    InvalidInputError
        If the coherence is missing: without it no residual can be weighed; or if no line is left to fit.
    """
    measurement = _on_the_axis(measurement.to(FrfKind.INERTANCE))
    g2 = _weighable(measurement)
    analyser = measurement.setup.analyser
    frf, n = measurement.frf, measurement.averages
    # H1, whatever the estimator was: H2 = H1 / g2 and Hv = H1 / g.
    power = {"h1": 0.0, "h2": 1.0, "hv": 0.5}[analyser.estimator]
    h = frf.values[:, :, 0] * g2**power
    usable = (g2 > USABLE) & (frf.freq > 0)[:, None] & (np.abs(h) > 0)
    error = np.sqrt((1 - g2) / (2 * np.maximum(g2, FAINT) * (n - 2)) + NUMERICAL**2)
    force, incoherent, spread = measurement.force_spectrum, None, None
    if measurement.response_spectrum is not None:
        loose = measurement.response_spectrum * (1 - g2)
        floor = INCOHERENT * measurement.response_spectrum
        incoherent = loose * np.exp(np.log(n) - digamma(n - 1)) + floor
        # Where rounding is the larger part, the logarithm says nothing: its error is of order one.
        rounding = floor / (loose + floor + 1e-300)
        spread = polygamma(1, n - 1) * (1 - rounding) ** 2 + rounding**2 + NUMERICAL**2
    runs = slice(None) if measurement.setup.accelerometers.roving else slice(0, 1)
    out = np.array([d.point in {h.point for h in held_out} for d in frf.outputs])
    lines = np.zeros(len(frf.freq), bool)
    if not out.any() and fraction > 0:
        lines[2 :: max(2, round(1 / fraction))] = True
    window = WINDOWS[analyser.window].samples(256) ** 2
    observed = Observed(
        freq=frf.freq,
        outputs=frf.outputs,
        h=_nowhere_zero(h),
        error=error,
        coherence=g2,
        force=None if force is None else _nowhere_zero(force[:, runs, 0]) * np.exp(np.log(n) - digamma(n)),
        force_variance=float(polygamma(1, n)) + NUMERICAL**2,
        incoherent=None if incoherent is None else _nowhere_zero(incoherent),
        incoherent_variance=spread,
        usable=usable,
        held_out=out,
        held_lines=lines,
        correlation=float((window**2).mean() / window.mean() ** 2),
    )
    _check_something_is_left(observed)
    return observed


def _check_something_is_left(observed: Observed) -> None:
    if not observed.usable.any():
        raise InvalidInputError(
            "no line shows a response",
            field="coherence",
            value=float(observed.coherence.max()),
            allowed=f"> {USABLE}",
        )
    if not observed.fitted.any():
        held = [str(dof) for dof, out in zip(observed.outputs, observed.held_out, strict=True) if out]
        raise InvalidInputError(
            "with these held out nothing is left to fit", field="hold_out", value=", ".join(held)
        )
