"""Where prediction and measurement of a diagnosis differ."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ModeShift:
    """How a resonance differs from the model's; None where the test does not tell."""

    mode: int  # elastic modes of the model, from 1
    frequency: float  # Hz, of the model
    frequency_shift: float | None  # measured over the model's, minus 1
    frequency_error: float | None  # its standard error
    loss_factor_shift: float | None  # the same of the loss factor
    loss_factor_error: float | None


@dataclass(frozen=True)
class ResponseMisfit:
    """How the FRF of one response differs, on average over all lines, with standard errors."""

    dof: str
    gap: float | None  # mean squared residual
    amplitude: float | None  # measured over predicted
    amplitude_error: float | None
    phase: float | None  # rad
    phase_error: float | None
    delay: float | None  # s by which the measured one lags behind
    delay_error: float | None
    course: str | None = None  # gain, polarity, delay or rising_gain, if that is nearly all of it


@dataclass(frozen=True)
class Located:
    """Where prediction and measurement differ."""

    bands: tuple[tuple[float, float], ...] = ()  # Hz
    dofs: tuple[str, ...] = ()
    modes: tuple[int, ...] = ()  # counted from 1
    words: tuple[str, ...] = ()  # the same in sentences
    signs: tuple[str, ...] = ()  # what is telling, as force_only, one_response, low_frequency
    mode_shifts: tuple[ModeShift, ...] = ()
    responses: tuple[ResponseMisfit, ...] = ()
    level_dependence: float | None = None  # gap between tests at two levels; None: one level only
