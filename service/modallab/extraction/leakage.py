"""What a window did to the lines, and how to undo it for one mode."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Self

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, frozen
from modallab.core.errors import InvalidInputError

MIN_SAMPLES = 256  # a window's autocorrelation is smooth: this many give it to 1e-5


class Biased(StrEnum):
    """Which estimate of the response the lines are: each leaks in its own way."""

    H1 = "h1"
    H2 = "h2"
    HV = "hv"


@dataclass(frozen=True, eq=False)
class Leakage:
    """Random records cut by a window: each line holds its neighbours too.

    `lag` from 0 to 1 of a record and `correlation`, the window's autocorrelation there (1 at 0), are the
    Fourier transform of the window's power spectrum of unit area [5.11].
    """

    lag: FloatArray  # (n_lag,) quadrature nodes
    correlation: FloatArray  # (n_lag,) autocorrelation times quadrature weight
    estimator: Biased

    def __post_init__(self) -> None:
        object.__setattr__(self, "lag", frozen(self.lag, float, (None,), name="lag"))
        shape = self.lag.shape
        object.__setattr__(self, "correlation", frozen(self.correlation, float, shape, name="correlation"))

    @classmethod
    def of(cls, window: FloatArray, estimator: str) -> Self:
        """Return the leakage of a window.

        Parameters
        ----------
        window
            (n_samples,) its values over one record, any scale.
        estimator
            "h1", "h2" or "hv".

        Raises
        ------
        InvalidInputError
            For another estimator, or a window of few samples or without area.
        """
        if estimator not in list(Biased):
            raise InvalidInputError(
                f"leakage of {estimator!r} is not known",
                field="estimator",
                value=estimator,
                allowed=", ".join(Biased),
            )
        window = np.asarray(window, float)
        if window.ndim != 1 or len(window) < MIN_SAMPLES or not np.abs(window).max() > 0:
            raise InvalidInputError(
                "the window must be given over one record",
                field="window",
                value=str(window.shape),
                allowed=f"at least {MIN_SAMPLES} samples, not all zero",
            )
        spectrum = np.fft.rfft(window, 2 * len(window))
        correlation = np.fft.irfft(np.abs(spectrum) ** 2)[: len(window)]
        # 96 Gauss nodes integrate up to about 60 turns of the exponential, so as many lines away
        lag, weight = np.polynomial.legendre.leggauss(96)
        lag = (lag + 1) / 2
        at = np.interp(lag, np.arange(len(window)) / len(window), correlation / correlation[0])
        return cls(lag, at * weight / 2, Biased(estimator))

    def undone(
        self,
        freq: FloatArray,
        spacing: float,
        eigenvalue: ComplexArray,
        constant: ComplexArray,
        rest: ComplexArray,
    ) -> ComplexArray:
        """Return what to multiply leaked inertance by, if one mode and a smooth rest are all there is.

        The force is flat over a window's width, so `E[H1] = W * H` and `E[H2] = (W * |H|^2)/(W * conj H)`,
        `*` being the convolution by the window's power spectrum W, and Hv is their geometric mean. All
        follow from the closed form of a pole's convolution.

        Parameters
        ----------
        freq
            (..., n_lines) Hz.
        spacing
            Of the lines, Hz: one over the record's length.
        eigenvalue
            (...) lambda_r, (rad/s)^2.
        constant
            (...) modal constant of the inertance, `-lambda_r A_r`.
        rest
            (..., n_lines) inertance beside that of the mode; it leaks unchanged.
        """
        pole = np.sqrt(eigenvalue)[..., None] / (2 * np.pi)
        strength = constant[..., None] / (8 * np.pi**2 * pole * spacing)
        # far from its mirror pole, which joins the rest, a mode is one pole in frequency
        rest = rest + strength * spacing / (pole + freq)
        gap = (pole - freq) / spacing
        spread = -2j * np.pi * (np.exp(2j * np.pi * gap[..., None] * self.lag) @ self.correlation)
        cross = strength * spread + rest
        auto = -(np.abs(strength) ** 2) * spread.imag / gap.imag
        auto = auto + 2 * (rest.conj() * strength * spread).real + np.abs(rest) ** 2
        match self.estimator:
            case Biased.H1:
                leaked = cross
            case Biased.H2:
                leaked = auto / cross.conj()
            case Biased.HV:
                leaked = np.sqrt(np.maximum(auto, 0)) * cross / np.abs(cross)
        return np.asarray((strength / gap + rest) / np.where(leaked == 0, 1, leaked))
