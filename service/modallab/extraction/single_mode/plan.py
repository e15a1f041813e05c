"""Choice of the lines of single-mode fits from the kind of data, with reasons."""

from collections.abc import Mapping
from dataclasses import dataclass

from modallab.extraction.options import DistantLinesOptions, ExtractionOptions, SingleModeOptions
from modallab.extraction.preprocessing.leakage import NoiseBias, WindowLeakage
from modallab.extraction.single_mode.settings import LINE_CHOICE

REQUESTED = "as requested"


@dataclass(frozen=True)
class Plan:
    """Lines of single-mode fits."""

    lines: int
    """Lines about each resonance, including those left out."""
    widths: float
    """Least width in half-power bandwidths."""
    leave_out: int
    """Lines nearest to resonance that are not used."""
    choices: Mapping[str, str]
    """Value and reason of each option."""


def plan(options: SingleModeOptions, leakage: WindowLeakage | None) -> Plan:
    """Return the options of the user, completed from the data."""
    leave_out, why_out = _leave_out(options, leakage)
    lines, why_lines = _lines(options, leakage)
    if options.lines is None:
        lines += leave_out
    choices = {
        "lines": f"{lines}: {why_lines}",
        "leave_out": f"{leave_out}: {why_out}",
        "damping": damping_choice(options),
    }
    return Plan(lines, LINE_CHOICE.half_power_widths if options.lines is None else 0.0, leave_out, choices)


def damping_choice(options: ExtractionOptions) -> str:
    """Return the damping law, and whether it was requested."""
    reason = "the default" if options.damping is None else REQUESTED
    return f"{options.assumed_damping}: {reason}"


def choice_value(choices: Mapping[str, str], option: str) -> str | None:
    """Return the value of an option without its reason; None if there is no such choice."""
    text = choices.get(option)
    return None if text is None else text.split(":", 1)[0]


def _lines(options: SingleModeOptions, leakage: WindowLeakage | None) -> tuple[int, str]:
    if options.lines is not None:
        return options.lines, REQUESTED
    minimum = f"or {LINE_CHOICE.half_power_widths:g} half-power bandwidths if that is more"
    if leakage is None:
        return (
            LINE_CHOICE.lines,
            f"{minimum}; no leakage, and near lines contain least of other modes",
        )
    return LINE_CHOICE.leaked_lines, f"{minimum}; with leakage, far lines are less distorted"


def _leave_out(options: SingleModeOptions, leakage: WindowLeakage | None) -> tuple[int, str]:
    able = isinstance(options, DistantLinesOptions)
    if isinstance(options, DistantLinesOptions) and options.leave_out is not None:
        return options.leave_out, REQUESTED
    if leakage is None:
        return 0, "no leakage, and the lines nearest resonance determine the damping best"
    # if few lines are requested, as many remain as in data without leakage
    spare = (
        LINE_CHOICE.h1_left_out
        if options.lines is None
        else min(max(options.lines - LINE_CHOICE.lines, 0), LINE_CHOICE.h1_left_out)
    )
    if leakage.estimator is NoiseBias.H1 and able and spare:
        return spare, (
            "leakage reduces h1 most at resonance; it is corrected line by line, but the lines nearest "
            "resonance remain the least certain"
        )
    return 0, f"leakage of {leakage.estimator} is corrected line by line, near resonance too"
