"""Summary of a diagnosis as a few lines of plain text, for a terminal."""

from textwrap import fill

from modallab.diagnosis.reporting.settings import TERMINAL
from modallab.diagnosis.reporting.text import (
    effect_name,
    equivalence_statement,
    gap_reduction,
    location_statements,
    next_test_text,
    parameter_list,
    probability_statement,
)
from modallab.diagnosis.reporting.unknown_effect import unknown_text
from modallab.diagnosis.reporting.verdict_text import headline, verdict_text
from modallab.diagnosis.result import Diagnosis, Step


def summary(diagnosis: Diagnosis) -> str:
    """Return verdict, location, missing effects with sizes and probabilities, and the remaining gap."""
    lines = [headline(diagnosis), fill(verdict_text(diagnosis), TERMINAL.width), ""]
    places = location_statements(diagnosis.located)
    lines += [_labelled("" if i else "where", text) for i, text in enumerate(places)]
    for number, step in enumerate(diagnosis.steps, 1):
        lines += ["", *_step_lines(number, step)]
    if diagnosis.unknown is not None:
        lines += ["", _labelled("unknown", unknown_text(diagnosis.unknown))]
    if diagnosis.next_test is not None:
        lines += ["", _labelled("next test", next_test_text(diagnosis.next_test))]
    lines += ["", *(_labelled("note", note) for note in diagnosis.notes)]
    return "\n".join(lines).strip()


def _step_lines(number: int, step: Step) -> list[str]:
    fitted = gap_reduction(step.gap_before, step.gap_after)
    held_out = gap_reduction(step.held_out_gap_before, step.held_out_gap_after)
    lines = [
        _labelled(f"missing {number}", f"{effect_name(step.effect)}: {parameter_list(step.effect)}"),
        _labelled("certainty", probability_statement(step)),
        _labelled("gap", f"{fitted} on the fitted FRFs, {held_out} on the held-out FRFs"),
    ]
    if step.rivals_alike:
        lines.append(_labelled("rivals", equivalence_statement(step)))
    return lines


def _labelled(label: str, text: str) -> str:
    indent = " " * TERMINAL.label_width
    return fill(
        text, TERMINAL.width, initial_indent=label.ljust(TERMINAL.label_width), subsequent_indent=indent
    )
