"""Settings of the FFT analyser."""

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.estimation.windows import WINDOWS, Window
from modallab.rig.excitation import EXCITATIONS, ExcitationSetting
from modallab.rig.hardware import within

__all__ = ["Analyser", "ExcitationSetting"]


@dataclass(frozen=True)
class Analyser:
    """Settings of the FFT analyser."""

    frequency_max: float = 800.0
    """Hz, top of the band."""
    n_lines: int = 401
    """lines, number of frequency lines with 0 Hz."""
    window: str = "rectangular"
    """Name of the window."""
    averages: int = 100
    """1, number of averages."""
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

    def __post_init__(self) -> None:
        within("frequency_max", self.frequency_max, 1e-3, 1e6)
        within("n_lines", self.n_lines, 8, 20001)
        within("window_end", self.window_end, 1e-6, 0.999)
        within("force_width", self.force_width, 1e-3, 0.999)
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
        """(n_lines,) Hz, from 0."""
        return np.linspace(0.0, self.frequency_max, self.n_lines)

    @property
    def spacing(self) -> float:
        """Distance of two lines, Hz."""
        return self.frequency_max / (self.n_lines - 1)

    @property
    def record_length(self) -> float:
        """Length of one record, s."""
        return 1.0 / self.spacing

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
