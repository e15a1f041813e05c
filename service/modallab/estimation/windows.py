"""Windows of the analyser and their line shapes."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.core.registry import Family
from modallab.estimation.settings import SPECTRUM

WINDOWS: Family["Window"] = Family("window", home=__name__)


@dataclass(frozen=True)
class Window:
    """A sum of cosines over the record: w = a_0 - a_1 cos(2 pi t/T) + a_2 cos(4 pi t/T) - ...

    Windows for signals that begin and end within a record are none of it, but weigh its parts: forces
    are let through until the pulse is over, and all channels fall exponentially to `end` at the end.
    """

    summary: str
    coefficients: tuple[float, ...] = (1.0,)
    force_width: float = 1.0  # share of the record after which a force channel is cut off
    end: float = 1.0

    @property
    def transient(self) -> bool:
        """Whether the window is for transients, which begin and end within a record."""
        return self.force_width < 1 or self.end < 1

    @property
    def power(self) -> float:
        """Mean square of the sum of cosines, by which spectra are divided.

        Weights of parts of a record leave a pulse at its start as it is, and so the size of spectra.
        """
        a = np.array(self.coefficients)
        return float(a[0] ** 2 + (a[1:] ** 2).sum() / 2)

    def samples(self, n: int) -> FloatArray:
        """Return the window (n,) of a response channel; a sum of cosines is periodic in the record."""
        angle = 2 * np.pi * np.arange(n) / n
        signs = (-1.0) ** np.arange(len(self.coefficients))
        terms = [
            s * a * np.cos(k * angle) for k, (s, a) in enumerate(zip(signs, self.coefficients, strict=True))
        ]
        return np.asarray(np.sum(terms, axis=0) * self.end ** (np.arange(n) / n))

    def weights(self, n: int, n_in: int, n_out: int) -> FloatArray:
        """Return the windows of all channels, (n_in + n_out, n), forces first."""
        response = self.samples(n)
        taper_phase = (self.force_width - np.arange(n) / n) / (SPECTRUM.force_taper * self.force_width)
        passed = (
            np.sin(np.pi / 2 * np.clip(taper_phase, 0.0, 1.0)) ** 2 if self.force_width < 1 else np.ones(n)
        )
        return np.vstack([np.tile(response * passed, (n_in, 1)), np.tile(response, (n_out, 1))])

    def lines(self, lines: ComplexArray) -> ComplexArray:
        """Return the lines (n_run, n_lines, n_ch) of windowed records, over the window's root mean square.

        Of a sum of cosines, by neighbouring lines.
        """
        half_width, n = len(self.coefficients) - 1, lines.shape[1]
        zeros = np.zeros((len(lines), half_width, lines.shape[2]))
        # Lines at negative frequency are conjugate; the record of a channel is real.
        extended_lines = np.concatenate([lines[:, half_width:0:-1].conj(), lines, zeros], axis=1)
        extended_lines[:, half_width] = extended_lines[:, half_width].real
        windowed = self.coefficients[0] * extended_lines[:, half_width : half_width + n]
        for m, a in enumerate(self.coefficients[1:], start=1):
            windowed = windowed + (-1) ** m * a / 2 * (
                extended_lines[:, half_width - m : half_width - m + n]
                + extended_lines[:, half_width + m : half_width + m + n]
            )
        return np.asarray(windowed / np.sqrt(self.power))

    def noise_shares(self, n_in: int, n_out: int) -> FloatArray:
        """Return the factor of white noise in each channel's spectrum, (n_in + n_out,), forces first."""
        return np.repeat(_noise_shares(self), (n_in, n_out))

    def line_shape(self, offset: FloatArray, n: int | None = None) -> FloatArray:
        """Return the power at a line from a signal `offset` lines away, of unit area over lines.

        The power window of 1992 thesis eq. [5.12], [5.13] times the line spacing; closed form. Of a window
        that weighs parts of a record: of its response channels, as much below unit area as it takes away.

        Parameters
        ----------
        n
            Samples of a record: the shape comes again every n lines. None: of continuous time.
        """
        if self.transient:
            decay = -np.log(self.end) + 2j * np.pi * offset
            short = decay if n is None else -n * np.expm1(-decay / n)
            exponent = np.where(decay == 0, 1.0, short)
            return np.asarray(np.abs(np.where(decay == 0, 1.0, -np.expm1(-decay) / exponent)) ** 2)
        amplitude = self.coefficients[0] * _kernel(offset, n)
        for k, a in enumerate(self.coefficients[1:], start=1):
            amplitude = amplitude + a / 2 * (_kernel(offset - k, n) + _kernel(offset + k, n))
        return np.asarray(np.abs(amplitude) ** 2 / self.power)

    def envelope(self, offset: FloatArray, n: int | None = None) -> FloatArray:
        """Return `line_shape(offset, n) / sin(pi offset)^2`: smooth but for its poles.

        In continuous time it is a rational function of the offset y. For records of n samples it is the same
        function of s = sin(pi y/n) times 1 - s^2, plus a term from the first sample of the window.

        Parameters
        ----------
        offset
            In lines, no whole numbers: the poles are at whole numbers up to the number of cosines.
        """
        place = offset if n is None else np.sin(np.pi / n * offset)
        poles = np.arange(len(self.coefficients), dtype=float)
        poles = poles if n is None else np.sin(np.pi / n * poles)
        rational = self.coefficients[0] / place
        square = place * place
        for k, a in enumerate(self.coefficients[1:], start=1):
            rational += (-1) ** k * a * place / (square - poles[k] ** 2)
        rational *= rational
        if n is None:
            rational /= np.pi**2 * self.power
            return rational
        rational *= 1 - square
        rational += self.samples(1)[0] ** 2
        rational /= n**2 * self.power
        return rational

    def line_shapes(self, lines: FloatArray, place: FloatArray, n: int | None = None) -> FloatArray:
        """Return `line_shape(lines - place, n)`, (n_lines, n_places), ten times faster.

        Parameters
        ----------
        lines
            (n_lines,) whole numbers.
        place
            (n_places,) in lines, none of them whole: sin(pi (line - place)) is then +-sin(pi place), one
            sine a place, over a smooth function.
        n
            Samples of a record; None: of continuous time.
        """
        shapes = self.envelope(lines[:, None] - place, n)
        shapes *= np.sin(np.pi * (place - np.round(place))) ** 2
        return shapes


def _kernel(offset: FloatArray, n: int | None) -> ComplexArray | FloatArray:
    """Return the amplitude at a line of a unit signal at mid-record `offset` lines away, no window."""
    if n is None:
        return np.sinc(offset)
    denominator = np.sinc(offset / n)
    # over the whole period: where the sine below the line is 0 again, the one above is too
    periodic = np.abs(denominator) < PRODUCT_ROUNDING
    size = np.where(
        periodic, np.cos(np.pi * (n - 1) * offset / n), np.sinc(offset) / np.where(periodic, 1.0, denominator)
    )
    return np.asarray(size * np.exp(1j * np.pi * offset / n))


WINDOWS.register("rectangular")(Window("none: right for signals that repeat with the record", (1.0,)))
WINDOWS.register("hann")(Window("smooth ends: little leakage into far lines", (0.5, 0.5)))
WINDOWS.register("flat_top")(
    Window(
        "true amplitude of a sine between two lines, at the price of wide lines",
        (0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368),
    )
)
WINDOWS.register("force")(
    Window(
        "of impacts: the force is let through until the pulse is over, its noise after that is not",
        force_width=0.2,
    )
)
WINDOWS.register("exponential")(
    Window("of impacts: all channels fall exponentially, which adds a known damping", end=0.01)
)
WINDOWS.register("force_exponential")(
    Window(
        "of impacts: exponential on all channels, and the force cut off after its pulse",
        force_width=0.2,
        end=0.01,
    )
)


def added_loss_factor(end: float, record_length: float, frequency: FloatArray) -> FloatArray:
    """Return the loss factors added to modes by an exponential window, (n_modes,).

    exp(-sigma t) on force and response moves every pole by -sigma, whatever its damping: a mode of
    frequency f looks as if its loss factor were larger by 2 sigma / (2 pi f), sigma = -ln(end)/T.

    Parameters
    ----------
    end
        Height of the window at the end of the record, 1 where there is none.
    record_length
        T, s.
    frequency
        (n_modes,) Hz.
    """
    return np.asarray(-np.log(end) / (np.pi * record_length * frequency))


@lru_cache(maxsize=64)
def _noise_shares(window: Window) -> FloatArray:
    """Return the factors of white noise in a force and in a response channel, (2,)."""
    return np.asarray((window.weights(SPECTRUM.window_samples, 1, 1) ** 2).mean(axis=1) / window.power)
