"""What an extraction method is: one mode from each of many short stretches of FRF."""

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
    """How a fit ended; batched fits say so instead of raising."""

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

    frequency: float  # Hz
    loss_factor: float
    modal_constant: complex  # 1/kg for receptance
    residual: complex = 0j  # unit of the response

    def response(self, freq: FloatArray) -> ComplexArray:
        """Return the response of this mode with its residual, shaped as `freq`, Hz."""
        eigenvalue = (2 * np.pi * self.frequency) ** 2 * (1 + 1j * self.loss_factor)
        gap = eigenvalue - (2 * np.pi * freq) ** 2
        return np.asarray(self.modal_constant / gap + self.residual, np.complex128)


@dataclass(frozen=True, eq=False)
class ModeFits:
    """Many single-mode fits at once; every array is (n_fits,), and zero where nothing was found."""

    frequency: FloatArray  # Hz
    loss_factor: FloatArray
    modal_constant: ComplexArray
    residual: ComplexArray
    # Standard errors from the random error of the lines; of a complex number: of either of its parts.
    frequency_error: FloatArray  # Hz
    loss_factor_error: FloatArray
    modal_constant_error: FloatArray
    residual_error: FloatArray
    # mean square residual over the lines' variance: 1 when only random error is left, 0 if no line is fitted
    misfit: FloatArray
    outcome: IntArray  # Outcome
    quality: dict[str, FloatArray] = field(default_factory=dict)  # what only this method can tell, %

    @property
    def found(self) -> BoolArray:
        """(n_fits,) True where there is a mode."""
        return np.asarray(self.outcome == Outcome.FOUND)

    def one(self, index: int) -> ModeFit:
        """Return one of the fits.

        Raises
        ------
        NoModeInBandError
            If that fit found nothing.
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
    """Returns one mode for every row.

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
    """Returns named arrays of what a method draws through one stretch of FRF, lines without weight left out.

    What lies along the axis is named `x...` and is `(2 pi freq)^2`, (rad/s)^2. Parameters as those of an
    `ExtractionMethod`, for one row, (n_lines,).
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
        If the band holds no resonance.
    """
    weight = np.ones(len(freq)) if weight is None else weight
    fits = method(freq[None], frf[None], weight[None])
    if not fits.found[0]:
        reason = REASONS[Outcome(int(fits.outcome[0]))]
        start, stop = (float(freq[0]), float(freq[-1])) if len(freq) else (0.0, 0.0)
        raise NoModeInBandError(f"{start:g} to {stop:g} Hz: {reason}", start=start, stop=stop)
    return fits.one(0)
