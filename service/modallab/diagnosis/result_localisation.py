"""Location of the disagreement between measurement and model, as a diagnosis states it."""

from dataclasses import dataclass
from enum import StrEnum

from modallab.core.dof import Dof
from modallab.core.reply import NanFloat


class GapPattern(StrEnum):
    """Pattern of the disagreement that points to a class of causes."""

    FORCE_ONLY = "force_only"  # FRFs and incoherent response spectra agree
    COHERENCE_ONLY = "coherence_only"  # FRFs and force spectra agree
    ONE_RESPONSE = "one_response"  # all other FRFs agree
    DRIVE_POINT_ONLY = "drive_point_only"
    LOW_FREQUENCY = "low_frequency"  # only the lowest quarter of the band disagrees
    HIGH_FREQUENCY = "high_frequency"  # only the highest quarter of the band disagrees
    LEVEL_DEPENDENCE = "level_dependence"  # FRFs measured at two force levels differ


@dataclass(frozen=True)
class ModeShift:
    """Shift of one mode against the model, with standard errors; nan where the test does not show it."""

    mode: int
    """Number of the elastic mode of the model, counted from 1."""
    frequency: float
    """Hz, natural frequency of the model."""
    frequency_shift: NanFloat
    """Natural frequency, measured over model, minus 1."""
    frequency_error: NanFloat
    """Standard error of `frequency_shift`."""
    loss_factor_shift: NanFloat
    """Loss factor, measured over model, minus 1."""
    loss_factor_error: NanFloat
    """Standard error of `loss_factor_shift`."""


class ChannelError(StrEnum):
    """Error of a channel, by the course of its FRF's deviation over frequency."""

    GAIN = "gain"  # constant factor
    POLARITY = "polarity"  # opposite sign
    DELAY = "delay"  # phase proportional to frequency
    RISING_GAIN = "rising_gain"  # factor that grows with the square of frequency


@dataclass(frozen=True)
class ResponseMisfit:
    """Deviation of one FRF, averaged over all lines, with standard errors."""

    dof: Dof
    """Measured DoF of the response."""
    gap: NanFloat
    """Mean squared residual of the FRF."""
    amplitude: NanFloat
    """Amplitude ratio, measured over predicted."""
    amplitude_error: NanFloat
    """Standard error of `amplitude`."""
    phase: NanFloat
    """rad, phase, measured minus predicted."""
    phase_error: NanFloat
    """rad, standard error of `phase`."""
    delay: NanFloat
    """s, delay of the measured response behind the predicted one."""
    delay_error: NanFloat
    """s, standard error of `delay`."""
    course: ChannelError | None = None
    """Channel error that accounts for nearly all of the gap; None: no single one does."""
    drive: Dof | None = None
    """DoF of the force; None: in results of earlier versions, which had one drive point."""


@dataclass(frozen=True)
class Localisation:
    """Location of the disagreement between the measurement and the model without added effects."""

    bands: tuple[tuple[float, float], ...] = ()
    """Hz, lower and upper limits of the frequency bands that disagree."""
    dofs: tuple[Dof, ...] = ()
    """Responses that disagree most; with a roving hammer struck points too."""
    modes: tuple[int, ...] = ()
    """Elastic modes of the model, counted from 1, in the bands that disagree."""
    words: tuple[str, ...] = ()
    """Statements in plain English."""
    signs: tuple[GapPattern, ...] = ()
    """Patterns that point to a class of causes."""
    mode_shifts: tuple[ModeShift, ...] = ()
    """Shifts of natural frequencies and loss factors."""
    responses: tuple[ResponseMisfit, ...] = ()
    """Deviation of each FRF."""
    level_dependence: float | None = None
    """Mean squared normalised difference of FRFs at two force levels; None: one level only."""
