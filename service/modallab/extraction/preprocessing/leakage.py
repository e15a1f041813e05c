"""Leakage of one mode through a window, and its correction."""

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Self

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, frozen
from modallab.core.errors import InvalidInputError, bounds
from modallab.extraction.preprocessing.settings import LEAKAGE


class NoiseBias(StrEnum):
    """FRF estimator, by which noise and leakage bias the lines."""

    H1 = "h1"
    H2 = "h2"
    HV = "hv"


def noise_bias_of(estimator: str) -> NoiseBias:
    """Return the estimator of a name.

    Raises
    ------
    InvalidInputError
        If the name is not that of an estimator with known leakage.
    """
    if estimator not in list(NoiseBias):
        raise InvalidInputError(
            f"no leakage correction for the estimator {estimator!r}",
            field="estimator",
            value=estimator,
            allowed=list(NoiseBias),
        )
    return NoiseBias(estimator)


@dataclass(frozen=True, eq=False)
class WindowLeakage:
    """Leakage of random records through a window: each line contains contributions of its neighbours.

    `ambiguity` is the ambiguity function of the window: the Fourier transform of the window times its copy
    delayed by `lag`, at separations of 0, 1, 2 ... lines. At separation 0 it is the autocorrelation of the
    window (1 at lag 0), whose transform is the window's power spectrum of unit area [5.11]; at larger
    separations it gives the correlation of two lines.
    """

    lag: FloatArray
    """(n_lag,) quadrature nodes from 0 to 1, in record lengths."""
    ambiguity: ComplexArray
    """(n_lag, n_separations) ambiguity function times the quadrature weight."""
    white_correlation: ComplexArray
    """(n_separations,) correlation of lines of a white signal: the ambiguity function at lag 0."""
    estimator: NoiseBias
    """Estimator of the FRFs."""
    source_mass: float = 0.0
    """kg, mass behind the force transducer that the source drives too: the exciter's armature."""
    error_correlation: float = 1.0
    """Sum of the squared correlations of a line's error with those of all lines, itself included; the
    variance of a fit to many lines grows by this factor."""
    variance: float = np.inf
    """lines^2, second moment of the window's power spectrum."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "lag", frozen(self.lag, float, (None,), name="lag"))
        ambiguity = frozen(self.ambiguity, complex, (len(self.lag), None), name="ambiguity")
        object.__setattr__(self, "ambiguity", ambiguity)
        white_correlation = frozen(
            self.white_correlation, complex, (ambiguity.shape[1],), name="white_correlation"
        )
        object.__setattr__(self, "white_correlation", white_correlation)

    @classmethod
    def from_window(cls, window: FloatArray, estimator: str, *, source_mass: float = 0.0) -> Self:
        """Return the leakage of a window.

        Parameters
        ----------
        window
            (n_samples,) values over one record, of any scale.
        estimator
            "h1", "h2" or "hv".
        source_mass
            kg, mass of the exciter's armature, by which the force drops at resonances.

        Raises
        ------
        InvalidInputError
            For another estimator, or a window of few samples or without area.
        """
        kind = noise_bias_of(estimator)
        window = np.asarray(window, float)
        if window.ndim != 1 or len(window) < LEAKAGE.minimum_samples or not np.abs(window).max() > 0:
            raise InvalidInputError(
                "the window must be given over one record, and not all zero",
                field="window",
                value=list(window.shape),
                allowed=bounds(LEAKAGE.minimum_samples, unit="samples"),
            )
        lag, weight = np.polynomial.legendre.leggauss(LEAKAGE.quadrature_nodes)
        lag = (lag + 1) / 2
        time = np.arange(len(window) + 1) / len(window)
        lagged_window = np.interp(lag[:, None] + time[:-1], time, np.append(window, 0.0), right=0.0)
        power = window**2
        error_correlation = len(window) * float((power**2).sum()) / float(power.sum()) ** 2
        slope = np.diff(window, prepend=0.0, append=0.0) * len(window) / (2 * np.pi)
        variance = float((slope**2).sum() / power.sum())  # unbounded if the window has a jump
        ambiguity = np.fft.rfft(window * lagged_window).conj() * (weight[:, None] / (2 * power.sum()))
        white_correlation = np.fft.rfft(power).conj() / power.sum()
        return cls(lag, ambiguity, white_correlation, kind, source_mass, error_correlation, variance)

    def correction(
        self, freq: FloatArray, spacing: float, response: "SinglePole", drive: "SinglePole"
    ) -> ComplexArray:
        """Return the ratio of true to leaked inertance for one mode and a smooth residual, (..., n_lines).

        The source is flat over the width of the window, the force is `1/(1 + m H_11)` of it [5.2]. Force and
        response are then each one pole, that of the structure with the armature, and a constant. Their
        spectra convolved with the window's power spectrum follow from the closed form of the convolution of a
        pole.

        Parameters
        ----------
        freq
            (..., n_lines) Hz.
        spacing
            Hz, frequency resolution: one over the record length.
        response, drive
            Inertance of this FRF and of the drive point, with the same eigenvalue.
        """
        signals = self.signals(freq, spacing, response, drive)
        pole_spectrum = signals.pole_response(self) @ self.ambiguity[:, 0]
        power = -pole_spectrum.imag / signals.gap.imag

        def convolved(a: ComplexArray, b: ComplexArray, c: ComplexArray, d: ComplexArray) -> ComplexArray:
            """Return (a/gap + b) times the conjugate of (c/gap + d), convolved with the window."""
            return np.asarray(
                a * c.conj() * power
                + a * d.conj() * pole_spectrum
                + b * (c * pole_spectrum).conj()
                + b * d.conj()
            )

        ff, fx, xx = (
            convolved(*signals.force, *signals.force).real,
            convolved(*signals.motion, *signals.force),
            convolved(*signals.motion, *signals.motion).real,
        )
        leaked = _estimate(self.estimator, ff, fx, xx)
        gap, strength, residual = response.in_lines(freq, spacing)
        return np.asarray((strength / gap + residual) / np.where(leaked == 0, 1, leaked))

    def signals(
        self, freq: FloatArray, spacing: float, response: "SinglePole", drive: "SinglePole"
    ) -> "Signals":
        """Return force and response near one mode; parameters as of `correction`."""
        gap, strength, residual = response.in_lines(freq, spacing)
        _, drive_strength, drive_residual = drive.in_lines(freq, spacing)
        force_level = 1 / (1 + self.source_mass * drive_residual)
        shift = self.source_mass * drive_strength * force_level
        loaded_gap = gap + shift
        # structure and armature are damped, although a fit that has not converged may have negative damping
        return Signals(
            loaded_gap.real + 1j * np.maximum(loaded_gap.imag, LEAKAGE.minimum_half_width),
            (-force_level * shift, force_level),
            (force_level * (strength - residual * shift), force_level * residual),
        )


@dataclass(frozen=True, eq=False)
class Signals:
    """Force and response to a flat source near one mode: each `a/gap + b`, as (a, b), (..., n_lines)."""

    gap: ComplexArray
    """Distance of the line from the pole of structure and armature, in lines."""
    force: tuple[ComplexArray, ComplexArray]
    """Coefficients (a, b) of the force."""
    motion: tuple[ComplexArray, ComplexArray]
    """Coefficients (a, b) of the response."""

    def pole_response(self, leakage: WindowLeakage) -> ComplexArray:
        """Return the impulse response of the pole at each `lag`, (..., n_lines, n_lag)."""
        return np.asarray(-2j * np.pi * np.exp(2j * np.pi * self.gap[..., None] * leakage.lag))


@dataclass(frozen=True, eq=False)
class SinglePole:
    """Inertance near one mode: `constant/(lambda_r - omega^2) + residual`."""

    eigenvalue: ComplexArray
    """(...) (rad/s)^2."""
    constant: ComplexArray
    """(...) residue of inertance, `-lambda_r A_r`."""
    residual: ComplexArray
    """(..., n_lines) smooth contribution of all else, which leakage does not change."""

    @classmethod
    def of_mode(
        cls, eigenvalue: ComplexArray, modal_constant: ComplexArray, x: FloatArray, background: ComplexArray
    ) -> Self:
        """Return a mode of receptance as a pole of inertance: there it is a pole and its modal constant.

        Parameters
        ----------
        eigenvalue, modal_constant
            (...) (rad/s)^2 and 1/kg.
        x
            (..., n_lines) omega^2, (rad/s)^2.
        background
            (..., n_lines) m/N, receptance beside the mode.
        """
        residual = modal_constant[..., None] - x * background
        return cls(eigenvalue, -eigenvalue * modal_constant, residual)

    def subset(self, frfs: slice) -> Self:
        """Return the pole in some FRFs."""
        return replace(
            self,
            eigenvalue=self.eigenvalue[frfs],
            constant=self.constant[frfs],
            residual=self.residual[frfs],
        )

    def in_lines(self, freq: FloatArray, spacing: float) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return the distance of the pole in lines, its residue and the residual, each (..., n_lines)."""
        pole = np.sqrt(self.eigenvalue)[..., None] / (2 * np.pi)
        strength = self.constant[..., None] / (8 * np.pi**2 * pole * spacing)
        # far from its mirror pole, which is added to the residual, a mode is one pole in frequency
        residual = self.residual + strength * spacing / (pole + freq)
        return np.asarray((pole - freq) / spacing), strength, residual


def _estimate(estimator: NoiseBias, ff: FloatArray, fx: ComplexArray, xx: FloatArray) -> ComplexArray:
    """Return the FRF estimate from auto-spectra and cross-spectrum."""
    match estimator:
        case NoiseBias.H1:
            return np.asarray(fx / np.where(ff == 0, 1, ff))
        case NoiseBias.H2:
            return np.asarray(xx / np.where(fx == 0, 1, fx.conj()))
        case NoiseBias.HV:
            size = np.sqrt(np.maximum(xx / np.where(ff == 0, 1, ff), 0))
            return np.asarray(size * np.exp(1j * np.angle(fx)))
