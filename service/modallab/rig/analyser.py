"""Settings of the FFT analyser."""

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.estimation.windows import WINDOWS, Window
from modallab.rig.excitation import EXCITATIONS, ExcitationSetting
from modallab.rig.hardware import within
from modallab.rig.settings import ACQUISITION, SOURCE

__all__ = ["Analyser", "ExcitationSetting"]


@dataclass(frozen=True)
class Analyser:
    """Settings of the FFT analyser."""

    frequency_max: float = 800.0
    """Hz, last line, and top of the band that the source drives."""
    n_lines: int = 401
    """lines, number of frequency lines from the first to the last."""
    window: str = "rectangular"
    """Name of the window."""
    averages: int | None = 100
    """1, number of averages; None: unknown, of a simulated test 100."""
    overlap: float = 0.0
    """1, overlap of successive records over their length, 0 to 0.9."""
    estimator: str = "h1"
    """FRF estimator: `h1`, `h2` or `hv`."""
    bits: int | None = None
    """Resolution of the converter; None: ideal, without steps and limit."""
    range_factor: float = 4.0
    """1, full scale over the rms of each channel's signal, if `bits` is given."""
    excitation: ExcitationSetting = field(default_factory=ExcitationSetting)
    """Kind and level of the source signal."""
    coupling: Literal["dc", "ac"] = "dc"
    """Input coupling of all channels."""
    coupling_frequency: float = 1.0
    """Hz, -3 dB frequency of AC coupling."""
    mass_cancellation: float = 0.0
    """kg, mass whose inertia is subtracted from the force."""
    window_end: float = 0.01
    """1, height of an exponential window at the end of the record."""
    force_width: float = 0.2
    """1, width of a force window over the record length."""
    frequency_min: float = 0.0
    """Hz, first line; what lies below it was not kept."""

    def __post_init__(self) -> None:
        within("frequency_max", self.frequency_max, 1e-3, 1e6)
        within("n_lines", self.n_lines, 8, 1_000_000)
        within("frequency_min", self.frequency_min, 0.0, np.nextafter(self.frequency_max, 0.0))
        within("window_end", self.window_end, *ACQUISITION.window_end_bounds)
        within("force_width", self.force_width, 1e-3, 0.999)
        if self.averages is not None:
            within("averages", self.averages, 1, 100_000)
        within("overlap", self.overlap, 0.0, 0.9)
        within("coupling_frequency", self.coupling_frequency, 0.0, 1e4)
        within("mass_cancellation", self.mass_cancellation, 0.0, 5.0)
        within("range_factor", self.range_factor, 0.5, 100.0)
        if self.bits is not None:
            # A step of twice the rms at most: with coarser ones a record may hold nothing but zeros.
            within("bits", self.bits, max(4, int(np.ceil(np.log2(self.range_factor)))), 32)

    @property
    def freq(self) -> FloatArray:
        """(n_lines,) Hz, from the first line to the last."""
        return np.linspace(self.frequency_min, self.frequency_max, self.n_lines)

    @property
    def spacing(self) -> float:
        """Distance of two lines, Hz."""
        return (self.frequency_max - self.frequency_min) / (self.n_lines - 1)

    @property
    def baseband(self) -> "Analyser":
        """The same analyser with all lines from 0 Hz, of which it keeps those from `frequency_min` on.

        Raises
        ------
        InvalidInputError
            If the first line is no multiple of the spacing: no record from 0 Hz has these lines.
        """
        if self.frequency_min == 0:
            return self
        first = self.frequency_min / self.spacing
        if abs(first - round(first)) > ACQUISITION.line_tolerance:
            raise InvalidInputError(
                "the first line is no multiple of the spacing, as the lines of a record are",
                field="frequency_min",
                value=self.frequency_min,
                allowed=[round(first) * self.spacing],
            )
        return replace(self, frequency_min=0.0, n_lines=round(first) + self.n_lines)

    def lines_at(self, freq: FloatArray) -> IntArray:
        """Return the indices (n,) of frequencies (n,) Hz among the lines.

        Raises
        ------
        InvalidInputError
            If a frequency is on none of the lines.
        """
        place = (freq - self.frequency_min) / self.spacing
        lines = np.rint(place).astype(int)
        stray = (np.abs(place - lines) > ACQUISITION.line_tolerance) | (lines < 0) | (lines >= self.n_lines)
        if stray.any():
            first = int(stray.argmax())
            raise InvalidInputError(
                f"line {first + 1}, {freq[first]:.9g} Hz, is none that the log book declares",
                field="freq",
                value=float(freq[first]),
                allowed=f"{self.frequency_min:.9g} to {self.frequency_max:.9g} Hz by {self.spacing:.9g} Hz",
            )
        return lines

    @property
    def record_length(self) -> float:
        """Length of one record, s."""
        return 1.0 / self.spacing

    @property
    def simulated_averages(self) -> int:
        """Number of averages of a simulated test."""
        return SOURCE.averages if self.averages is None else self.averages

    @property
    def source_level(self) -> float:
        """Level of the source of a simulated test, N."""
        return SOURCE.level if self.excitation.level is None else self.excitation.level

    @property
    def driven_lines(self) -> tuple[int, int]:
        """First and last line that the source drives, counted from 0 Hz."""
        low, high = self.excitation.band or (0.0, self.frequency_max)
        rounding = ACQUISITION.line_tolerance
        return int(np.ceil(low / self.spacing - rounding)), int(np.floor(high / self.spacing + rounding))

    @property
    def band_ends_between_lines(self) -> FloatArray:
        """Limits of the source's frequency band that lie between two lines, (n,) Hz."""
        ends = np.array(self.excitation.band or (), float)
        place = ends / self.spacing
        between = np.abs(place - np.round(place)) > ACQUISITION.line_tolerance
        return np.asarray(ends[between & (place < self.n_lines - 1)])

    def source_density(self, freq: FloatArray) -> FloatArray:
        """Return the spectrum of the source at `freq` (n,) Hz, N^2/Hz.

        Flat over its band; beside it next to nothing is left.
        """
        low, high = self.excitation.band or (0.0, self.frequency_max)
        rounding = ACQUISITION.line_tolerance * self.spacing  # 400 times 502 Hz / 400 is below 502 Hz
        between = self.band_ends_between_lines
        inside = freq >= (low if low in between else low - rounding)
        inside &= freq <= (high if high in between else high + rounding)
        share = np.where(inside, 1.0, SOURCE.out_of_band)
        return np.asarray(self.source_level**2 / (high - low) * share)

    @property
    def line_window_kind(self) -> str:
        """Name of the window that acts on the lines: rectangular for stepped excitation."""
        return "rectangular" if EXCITATIONS[self.excitation.kind].line_by_line else self.window

    @property
    def line_window(self) -> Window:
        """The window that acts on the lines, with its parameters."""
        window = WINDOWS[self.line_window_kind]
        return replace(
            window,
            force_width=self.force_width if window.force_width < 1 else 1.0,
            end=self.window_end if window.end < 1 else 1.0,
        )
