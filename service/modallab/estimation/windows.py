"""Windows of the analyser and the shape they give to a line."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.registry import Family

WINDOWS: Family["Window"] = Family("window", home=__name__)


@dataclass(frozen=True)
class Window:
    """A sum of cosines over the record: w = a_0 - a_1 cos(2 pi t/T) + a_2 cos(4 pi t/T) - ..."""

    summary: str
    coefficients: tuple[float, ...]

    @property
    def power(self) -> float:
        """Mean square of the window."""
        a = np.array(self.coefficients)
        return float(a[0] ** 2 + (a[1:] ** 2).sum() / 2)

    def samples(self, n: int) -> FloatArray:
        """Return the window (n,), periodic in the record."""
        angle = 2 * np.pi * np.arange(n) / n
        signs = (-1.0) ** np.arange(len(self.coefficients))
        terms = [
            s * a * np.cos(k * angle) for k, (s, a) in enumerate(zip(signs, self.coefficients, strict=True))
        ]
        return np.asarray(np.sum(terms, axis=0))

    def line_shape(self, offset: FloatArray) -> FloatArray:
        """Return the power that a line takes from a signal `offset` lines away, unit area over lines.

        The power window of 1992 thesis eq. [5.12], [5.13] times the line spacing; closed form.
        """
        amplitude = self.coefficients[0] * np.sinc(offset)
        for k, a in enumerate(self.coefficients[1:], start=1):
            amplitude = amplitude + a / 2 * (np.sinc(offset - k) + np.sinc(offset + k))
        return np.asarray(amplitude**2 / self.power)

    def envelope(self, offset: FloatArray) -> FloatArray:
        """Return `line_shape(offset) / sin(pi offset)^2`: a rational function, smooth but for its poles.

        Parameters
        ----------
        offset
            In lines, none of them whole: there the poles are, out to the number of cosines.
        """
        rational = self.coefficients[0] / offset
        if len(self.coefficients) > 1:
            square = offset * offset
            for k, a in enumerate(self.coefficients[1:], start=1):
                rational += (-1) ** k * a * offset / (square - k**2)
        rational *= rational
        rational /= np.pi**2 * self.power
        return rational

    def line_shapes(self, lines: FloatArray, place: FloatArray) -> FloatArray:
        """Return `line_shape(lines - place)`, (n_lines, n_places), ten times faster.

        Parameters
        ----------
        lines
            (n_lines,) whole numbers.
        place
            (n_places,) in lines, none of them whole: sin(pi (line - place)) is then +-sin(pi place), one
            sine a place, over a rational function.
        """
        shapes = self.envelope(lines[:, None] - place)
        shapes *= np.sin(np.pi * (place - np.round(place))) ** 2
        return shapes


WINDOWS.register("rectangular")(Window("none: right for signals that repeat with the record", (1.0,)))
WINDOWS.register("hann")(Window("smooth ends: little leakage into far lines", (0.5, 0.5)))
WINDOWS.register("flat_top")(
    Window(
        "true amplitude of a sine between two lines, at the price of wide lines",
        (0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368),
    )
)
