"""What the user left open, decided from how the data were taken, with the reason."""

from collections.abc import Mapping
from dataclasses import dataclass

from modallab.extraction.options import DistantLinesOptions, ExtractionOptions, SingleModeOptions
from modallab.extraction.preprocessing.leakage import NoiseBias, WindowLeakage

LINES = 8  # periodic data: weighted fits draw on few lines, and near ones see least of other modes
LEAKY_LINES = 12  # leaked data: the far lines are the true ones
WIDTHS = 3.0  # a window spans at least so many half-power bandwidths, or the circle is but an arc
H1_LEFT_OUT = 4  # more exact than with them at any number of averages, for modes of one line or less
ASKED = "as asked"


@dataclass(frozen=True)
class Plan:
    """Which lines the fits of single modes draw on."""

    lines: int  # around each resonance, those left out among them
    widths: float  # half-power bandwidths that they span at least
    leave_out: int  # the nearest to resonance
    choices: Mapping[str, str]  # option -> what was taken, and why


def plan(options: SingleModeOptions, leakage: WindowLeakage | None) -> Plan:
    """Return what the user decided, the rest chosen from the data."""
    leave_out, why_out = _leave_out(options, leakage)
    lines, why_lines = _lines(options, leakage)
    if options.lines is None:
        lines += leave_out
    choices = {
        "lines": f"{lines}: {why_lines}",
        "leave_out": f"{leave_out}: {why_out}",
        "damping": law_of(options),
    }
    return Plan(lines, WIDTHS if options.lines is None else 0.0, leave_out, choices)


def law_of(options: ExtractionOptions) -> str:
    """Return the law of damping, and whether anybody asked for it."""
    return f"{options.law}: {'unless another is asked for' if options.damping is None else ASKED}"


def taken(choices: Mapping[str, str], option: str) -> str | None:
    """Return what was taken for an option, without the reason; None where nothing is said of it."""
    said = choices.get(option)
    return None if said is None else said.split(":", 1)[0]


def _lines(options: SingleModeOptions, leakage: WindowLeakage | None) -> tuple[int, str]:
    if options.lines is not None:
        return options.lines, ASKED
    wide = f"or {WIDTHS:g} half-power bandwidths where that is more"
    if leakage is None:
        return LINES, f"{wide}; the records do not leak, and near lines see least of other modes"
    return LEAKY_LINES, f"{wide}; the window leaks, and far lines are the truer ones"


def _leave_out(options: SingleModeOptions, leakage: WindowLeakage | None) -> tuple[int, str]:
    able = isinstance(options, DistantLinesOptions)
    if isinstance(options, DistantLinesOptions) and options.leave_out is not None:
        return options.leave_out, ASKED
    if leakage is None:
        return 0, "the records do not leak, and the lines nearest resonance say most of the damping"
    # of few lines asked for, those that periodic data would be read from are kept
    spare = H1_LEFT_OUT if options.lines is None else min(max(options.lines - LINES, 0), H1_LEFT_OUT)
    if leakage.estimator is NoiseBias.H1 and able and spare:
        return spare, (
            "leakage takes most from h1 where it is highest; it is undone line by line, but the lines "
            "nearest resonance are the least sure"
        )
    return 0, f"what the window did to {leakage.estimator} is undone line by line, near resonance too"
