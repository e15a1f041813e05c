"""What a window did to the lines, and how to undo it for one mode."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Self

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, frozen
from modallab.core.errors import InvalidInputError

MIN_SAMPLES = 256  # a window's autocorrelation is smooth: this many give it to 1e-5
LEAST_DAMPED = 1e-3  # lines
# Part of what leakage moves a mode by that undoing it may leave: the closed form is of one mode and a smooth
# rest. Without random error it leaves 0.1 to 3 % in loss factors of a free beam's modes 0.3 to 1.5 lines
# wide, 2 to 7 % at 1.9 lines, medians over eleven FRFs; at 0.2 lines, where errors feed back, up to 26 %.
LEFT = 0.05


class NoiseBias(StrEnum):
    """Which estimate of the response the lines are: each leaks in its own way."""

    H1 = "h1"
    H2 = "h2"
    HV = "hv"


def noise_bias_of(estimator: str) -> NoiseBias:
    """Return an estimator by its name.

    Raises
    ------
    InvalidInputError
        For another one.
    """
    if estimator not in list(NoiseBias):
        raise InvalidInputError(
            f"leakage of {estimator!r} is not known",
            field="estimator",
            value=estimator,
            allowed=", ".join(NoiseBias),
        )
    return NoiseBias(estimator)


@dataclass(frozen=True, eq=False)
class WindowLeakage:
    """Random records cut by a window: each line holds its neighbours too.

    `mixing` is the Fourier transform, line by line, of the window times itself a `lag` later, which is 0 to 1
    of a record. No line apart it is the window's autocorrelation (1 at 0), whose transform is the window's
    power spectrum of unit area [5.11]; one and more apart, it is what lines have in common.
    """

    lag: FloatArray  # (n_lag,) quadrature nodes
    mixing: ComplexArray  # (n_lag, n_apart) times quadrature weight
    together: ComplexArray  # (n_apart,) at no lag: the correlation of lines of a white signal
    estimator: NoiseBias
    source_mass: float = 0.0  # kg behind the force transducer, which the source drives too: an armature
    # The window makes errors of neighbouring lines alike: the sum of the squared correlations of a line's
    # error with those of all lines, itself included. What is fitted to many lines varies by so much more.
    alike: float = 1.0
    variance: float = np.inf  # of its power spectrum, lines^2

    def __post_init__(self) -> None:
        object.__setattr__(self, "lag", frozen(self.lag, float, (None,), name="lag"))
        mixing = frozen(self.mixing, complex, (len(self.lag), None), name="mixing")
        object.__setattr__(self, "mixing", mixing)
        together = frozen(self.together, complex, (mixing.shape[1],), name="together")
        object.__setattr__(self, "together", together)

    @classmethod
    def of(cls, window: FloatArray, estimator: str, *, source_mass: float = 0.0) -> Self:
        """Return the leakage of a window.

        Parameters
        ----------
        window
            (n_samples,) its values over one record, any scale.
        estimator
            "h1", "h2" or "hv".
        source_mass
            kg of the exciter's armature: it takes force at resonances, where the force then is not flat.

        Raises
        ------
        InvalidInputError
            For another estimator, or a window of few samples or without area.
        """
        kind = noise_bias_of(estimator)
        window = np.asarray(window, float)
        if window.ndim != 1 or len(window) < MIN_SAMPLES or not np.abs(window).max() > 0:
            raise InvalidInputError(
                "the window must be given over one record",
                field="window",
                value=str(window.shape),
                allowed=f"at least {MIN_SAMPLES} samples, not all zero",
            )
        # 96 Gauss nodes integrate up to about 60 turns of the exponential, so as many lines away
        lag, weight = np.polynomial.legendre.leggauss(96)
        lag = (lag + 1) / 2
        time = np.arange(len(window) + 1) / len(window)
        later = np.interp(lag[:, None] + time[:-1], time, np.append(window, 0.0), right=0.0)
        power = window**2
        alike = len(window) * float((power**2).sum()) / float(power.sum()) ** 2
        slope = np.diff(window, prepend=0.0, append=0.0) * len(window) / (2 * np.pi)
        variance = float((slope**2).sum() / power.sum())  # without bound for a window that jumps
        mixing = np.fft.rfft(window * later).conj() * (weight[:, None] / (2 * power.sum()))
        together = np.fft.rfft(power).conj() / power.sum()
        return cls(lag, mixing, together, kind, source_mass, alike, variance)

    def undone(self, freq: FloatArray, spacing: float, response: "OnePole", drive: "OnePole") -> ComplexArray:
        """Return what to multiply leaked inertance by, if one mode and a smooth rest are all there is.

        The source is flat over a window's width, the force `1/(1 + m H_11)` of it [5.2]. Both force and
        response are then one pole, that of the structure with the armature, and a constant, and their
        spectra convolved by the window's power spectrum follow from the closed form of a pole's convolution.

        Parameters
        ----------
        freq
            (..., n_lines) Hz.
        spacing
            Of the lines, Hz: one over the record's length.
        response, drive
            Inertance of the FRF in question, and of the drive point, with the same eigenvalue.
        """
        near = self.signals(freq, spacing, response, drive)
        spread = near.turning(self) @ self.mixing[:, 0]
        power = -spread.imag / near.gap.imag

        def convolved(a: ComplexArray, b: ComplexArray, c: ComplexArray, d: ComplexArray) -> ComplexArray:
            """The window over (a/gap + b) times the conjugate of (c/gap + d)."""
            return np.asarray(
                a * c.conj() * power + a * d.conj() * spread + b * (c * spread).conj() + b * d.conj()
            )

        ff, fx, xx = (
            convolved(*near.force, *near.force).real,
            convolved(*near.motion, *near.force),
            convolved(*near.motion, *near.motion).real,
        )
        leaked = _estimate(self.estimator, ff, fx, xx)
        gap, strength, rest = response.about(freq, spacing)
        return np.asarray((strength / gap + rest) / np.where(leaked == 0, 1, leaked))

    def signals(self, freq: FloatArray, spacing: float, response: "OnePole", drive: "OnePole") -> "Signals":
        """Return what force and response are near one mode; parameters as of `undone`."""
        gap, strength, rest = response.about(freq, spacing)
        _, drive_strength, drive_rest = drive.about(freq, spacing)
        force_level = 1 / (1 + self.source_mass * drive_rest)
        shift = self.source_mass * drive_strength * force_level
        loaded = gap + shift
        # a structure with its armature is damped; a fit that is not yet one may say otherwise
        return Signals(
            loaded.real + 1j * np.maximum(loaded.imag, LEAST_DAMPED),
            (-force_level * shift, force_level),
            (force_level * (strength - rest * shift), force_level * rest),
        )


@dataclass(frozen=True, eq=False)
class Signals:
    """Force and response over a flat source near one mode: `a/gap + b` each, as (a, b); (..., n_lines)."""

    gap: ComplexArray  # of the structure with its armature, in lines
    force: tuple[ComplexArray, ComplexArray]
    motion: tuple[ComplexArray, ComplexArray]

    def turning(self, leakage: WindowLeakage) -> ComplexArray:
        """Return the response of the pole to what came a `lag` before, (..., n_lines, n_lag)."""
        return np.asarray(-2j * np.pi * np.exp(2j * np.pi * self.gap[..., None] * leakage.lag))


@dataclass(frozen=True, eq=False)
class OnePole:
    """Inertance near one mode: `constant/(lambda_r - omega^2) + rest`."""

    eigenvalue: ComplexArray  # (...) (rad/s)^2
    constant: ComplexArray  # (...) -lambda_r A_r
    rest: ComplexArray  # (..., n_lines), smooth: it leaks unchanged

    def about(self, freq: FloatArray, spacing: float) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return pole minus line, in lines, the pole's strength and the rest, each (..., n_lines)."""
        pole = np.sqrt(self.eigenvalue)[..., None] / (2 * np.pi)
        strength = self.constant[..., None] / (8 * np.pi**2 * pole * spacing)
        # far from its mirror pole, which joins the rest, a mode is one pole in frequency
        rest = self.rest + strength * spacing / (pole + freq)
        return np.asarray((pole - freq) / spacing), strength, rest


def _estimate(estimator: NoiseBias, ff: FloatArray, fx: ComplexArray, xx: FloatArray) -> ComplexArray:
    match estimator:
        case NoiseBias.H1:
            return np.asarray(fx / np.where(ff == 0, 1, ff))
        case NoiseBias.H2:
            return np.asarray(xx / np.where(fx == 0, 1, fx.conj()))
        case NoiseBias.HV:
            size = np.sqrt(np.maximum(xx / np.where(ff == 0, 1, ff), 0))
            return np.asarray(size * np.exp(1j * np.angle(fx)))
