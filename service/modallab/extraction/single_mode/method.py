"""Interface of single-mode methods: one mode from each of many short ranges of lines."""

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from enum import IntEnum
from functools import partial, wraps
from typing import Any, Protocol

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.errors import NoModeInBandError
from modallab.core.registry import Family, first_line
from modallab.extraction.options import DistantLinesOptions, ExtractionOptions, SingleModeOptions


class Outcome(IntEnum):
    """Outcome of a fit in a batch, in place of an exception."""

    FOUND = 0
    TOO_FEW_LINES = 1
    NO_SHAPE = 2
    NO_RESONANCE = 3


REASONS = {
    Outcome.FOUND: "a mode was found",
    Outcome.TOO_FEW_LINES: "too few usable lines in the band",
    Outcome.NO_SHAPE: "the response does not change over the band",
    Outcome.NO_RESONANCE: "no resonance with positive damping in the band",
}


PAIRS = 32768  # of lines at once, half a megabyte an array: larger ones cost fresh pages each


@dataclass(frozen=True)
class ModeFit:
    """One hysteretic mode and a constant: A / (lambda_r - omega^2) + residual."""

    frequency: float
    """Hz, natural frequency."""
    loss_factor: float
    """1, loss factor."""
    modal_constant: complex
    """1/kg for receptance, modal constant A."""
    residual: complex = 0j
    """Unit of the response, constant residual."""

    def response(self, freq: FloatArray) -> ComplexArray:
        """Return the response of this mode with its residual, shaped as `freq`, Hz."""
        eigenvalue = (2 * np.pi * self.frequency) ** 2 * (1 + 1j * self.loss_factor)
        gap = eigenvalue - (2 * np.pi * freq) ** 2
        return np.asarray(self.modal_constant / gap + self.residual, np.complex128)


@dataclass(frozen=True, eq=False)
class ModeFits:
    """Batch of single-mode fits; all arrays are (n_fits,), zero where no mode was found.

    Standard errors follow from the random error of the lines; for a complex number they are those of real
    and imaginary part.
    """

    frequency: FloatArray
    """Hz, natural frequency."""
    loss_factor: FloatArray
    """1, loss factor."""
    modal_constant: ComplexArray
    """1/kg for receptance, modal constant A."""
    residual: ComplexArray
    """Unit of the response, constant residual."""
    frequency_error: FloatArray
    """Hz, standard error of the frequency."""
    loss_factor_error: FloatArray
    """1, standard error of the loss factor."""
    modal_constant_error: FloatArray
    """1/kg for receptance, standard error of the modal constant."""
    residual_error: FloatArray
    """Unit of the response, standard error of the residual."""
    misfit: FloatArray
    """1, mean squared residual over the variance of the lines; 0 if no line was fitted."""
    outcome: IntArray
    """Value of `Outcome`."""
    quality: dict[str, FloatArray] = field(default_factory=dict)
    """%, quality measures specific to the method, by name."""

    @property
    def found(self) -> BoolArray:
        """(n_fits,) True where there is a mode."""
        return np.asarray(self.outcome == Outcome.FOUND)

    def one(self, index: int) -> ModeFit:
        """Return one of the fits.

        Raises
        ------
        NoModeInBandError
            If that fit found no mode.
        """
        if self.outcome[index] != Outcome.FOUND:
            raise NoModeInBandError(REASONS[Outcome(int(self.outcome[index]))], fit=index)
        return ModeFit(
            float(self.frequency[index]),
            float(self.loss_factor[index]),
            complex(self.modal_constant[index]),
            complex(self.residual[index]),
        )


class ExtractionMethod(Protocol):
    """Function that returns one mode for every row.

    Parameters
    ----------
    freq
        (n_fits, n_lines) Hz.
    frf
        (n_fits, n_lines) receptance, m/N; or inertance, whose modal constant is `-lambda_r A_r`.
    weight
        (n_fits, n_lines) one over the expected square of each line's random error; 0 leaves a line out,
        so that rows of different length share one array.
    """

    def __call__(self, freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> ModeFits:
        """Return the fit of one mode for every row."""
        ...


class FitPlot(Protocol):
    """Function that returns the plot data of one fit as named arrays, without lines of weight 0.

    Abscissae have names `x...` and are `(2 pi freq)^2`, (rad/s)^2. Parameters as those of
    `ExtractionMethod` for one row, (n_lines,).
    """

    def __call__(
        self, freq: FloatArray, frf: ComplexArray, weight: FloatArray
    ) -> dict[str, FloatArray | ComplexArray]:
        """Return the plot data of the fits by name."""
        ...


@dataclass(frozen=True)
class SingleModeMethod:
    """A single-mode method with its options and its plot; called, it fits with default options."""

    fit: Callable[..., ModeFits]
    """Fit of many rows of lines: an `ExtractionMethod` that may take options as further keywords."""
    plot: Callable[..., dict[str, FloatArray | ComplexArray]]
    """Plot data of one row: a `FitPlot` that takes the same further keywords."""
    options: type[SingleModeOptions] = SingleModeOptions
    """Options dataclass of the method."""
    fit_options: tuple[str, ...] = ()
    """Names of the options that `fit` and `plot` take as keywords."""
    exact: bool = True
    """Whether clean lines of one mode and a constant give back that mode."""

    @property
    def summary(self) -> str:
        """First line of the method's description."""
        return first_line(self.fit)

    def __call__(self, freq: FloatArray, frf: ComplexArray, weight: FloatArray) -> ModeFits:
        """Return the fit of one mode for every row."""
        return self.fit(freq, frf, weight)

    @property
    def leaves_out(self) -> bool:
        """Whether the method can do without the lines nearest resonance."""
        return issubclass(self.options, DistantLinesOptions)

    def with_options(self, options: ExtractionOptions) -> ExtractionMethod:
        """Return the fit with its options set."""
        return partial(self.fit, **self._keywords(options))

    def plot_with_options(self, options: ExtractionOptions) -> FitPlot:
        """Return the plot with its options set."""
        return partial(self.plot, **self._keywords(options))

    def _keywords(self, options: ExtractionOptions) -> dict[str, Any]:
        return {name: getattr(options, name) for name in self.fit_options}


EXTRACTION_METHODS: Family[SingleModeMethod] = Family(
    "extraction method", home="modallab.extraction.single_mode.methods"
)


def in_blocks(method: Callable[..., ModeFits]) -> Callable[..., ModeFits]:
    """Return the method taking its rows some at a time, so that pairs of lines stay in the cache."""

    @wraps(method)
    def blocked(freq: FloatArray, frf: ComplexArray, weight: FloatArray, **options: Any) -> ModeFits:
        n_fits, n_lines = freq.shape
        step = max(PAIRS // max(n_lines, 1) ** 2, 16)
        rows = [slice(start, start + step) for start in range(0, max(n_fits, 1), step)]
        parts = [method(freq[row], frf[row], weight[row], **options) for row in rows]
        joined = {
            f.name: np.concatenate([getattr(part, f.name) for part in parts])
            for f in fields(ModeFits)
            if f.name != "quality"
        }
        quality = {name: np.concatenate([part.quality[name] for part in parts]) for name in parts[0].quality}
        return ModeFits(**joined, quality=quality)

    return blocked


def fit_mode(
    method: ExtractionMethod, freq: FloatArray, frf: ComplexArray, weight: FloatArray | None = None
) -> ModeFit:
    """Return the one mode that a single stretch of FRF shows.

    Parameters
    ----------
    method
        A member of `EXTRACTION_METHODS`.
    freq, frf
        (n_lines,) Hz and m/N.
    weight
        (n_lines,) one over the variance of each line; all alike by default.

    Raises
    ------
    NoModeInBandError
        If the band contains no resonance.
    """
    weight = np.ones(len(freq)) if weight is None else weight
    fits = method(freq[None], frf[None], weight[None])
    if not fits.found[0]:
        reason = REASONS[Outcome(int(fits.outcome[0]))]
        start, stop = (float(freq[0]), float(freq[-1])) if len(freq) else (0.0, 0.0)
        raise NoModeInBandError(f"{start:g} to {stop:g} Hz: {reason}", start=start, stop=stop)
    return fits.one(0)
