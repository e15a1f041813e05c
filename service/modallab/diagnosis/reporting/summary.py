"""A diagnosis as a few lines of plain text, for a terminal."""

from textwrap import fill

from modallab.diagnosis.reporting import text as wording
from modallab.diagnosis.result import Diagnosis, Step

WIDTH = 100
LABEL = 11  # columns before what is said


def summary(diagnosis: Diagnosis) -> str:
    """Return the verdict in plain words: what is missing, where, how large, how sure, what is left."""
    lines = [wording.headline(diagnosis), fill(wording.verdict(diagnosis), WIDTH), ""]
    places = wording.whereabouts(diagnosis.located)
    lines += [_said("" if i else "where", text) for i, text in enumerate(places)]
    for number, step in enumerate(diagnosis.steps, 1):
        lines += ["", *_of_step(number, step)]
    if diagnosis.next_test is not None:
        lines += ["", _said("next test", wording.next_test(diagnosis.next_test))]
    lines += ["", *(_said("note", note) for note in diagnosis.notes)]
    return "\n".join(lines).strip()


def _of_step(number: int, step: Step) -> list[str]:
    fitted = wording.closing(step.gap_before, step.gap_after)
    held_out = wording.closing(step.held_out_gap_before, step.held_out_gap_after)
    lines = [
        _said(f"missing {number}", f"{wording.name(step.effect)}: {wording.size(step.effect)}"),
        _said("sure", wording.sure(step)),
        _said("gap", f"{fitted} on the FRFs that were fitted, {held_out} on those held out of every fit"),
    ]
    if step.rivals_alike:
        lines.append(_said("alike", wording.alike(step)))
    return lines


def _said(label: str, text: str) -> str:
    return fill(text, WIDTH, initial_indent=f"{label:<{LABEL}}", subsequent_indent=" " * LABEL)
