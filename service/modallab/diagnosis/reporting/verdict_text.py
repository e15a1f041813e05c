"""Verdict of a diagnosis in words: the first sentences of its report."""

from modallab.diagnosis.localisation.text import PARTS
from modallab.diagnosis.reporting.text import effect_name, enumeration, gap_text
from modallab.diagnosis.reporting.unknown_effect import unknown_name
from modallab.diagnosis.result import Diagnosis, Step, Verdict
from modallab.diagnosis.searching.common_deviation import COMMON_EFFECTS


def headline(diagnosis: Diagnosis) -> str:
    """Return the verdict in one sentence."""
    steps = diagnosis.steps
    effects = enumeration([effect_name(step.effect) for step in steps])
    if diagnosis.verdict is Verdict.NOTHING_MISSING:
        return "Nothing is missing that this test can show."
    if diagnosis.verdict is Verdict.EXPLAINED:
        return f"Explained. Missing effect{'s' if len(steps) > 1 else ''}: {effects}."
    if diagnosis.verdict is Verdict.AMBIGUOUS:
        return f"Explained, but not uniquely: {effects}, or an equivalent effect."
    if diagnosis.verdict is Verdict.PARTLY_EXPLAINED:
        return (
            f"Partly explained: {effects} {'closes' if len(steps) == 1 else 'close'} most of the gap; what "
            f"remains, {_remainder(diagnosis)}, is more than random error and has no name."
        )
    return _unexplained_headline(diagnosis, effects)


def _remainder(diagnosis: Diagnosis) -> str:
    """Return what part of the gap remains: its share, or where too few data have it for the mean, these."""
    first, last = diagnosis.steps[0], diagnosis.steps[-1]
    if 1 < last.gap_after < first.gap_before:
        return f"{100 * (last.gap_after - 1) / (first.gap_before - 1):.2g} % of it"
    gaps = diagnosis.gaps["after"]
    return f"in the {PARTS[max(gaps, key=lambda part: gaps[part])]}"


def _unexplained_headline(diagnosis: Diagnosis, effects: str) -> str:
    steps, unknown = diagnosis.steps, diagnosis.unknown
    if unknown is not None and not unknown.beside_steps:
        gaps = f"{gap_text(unknown.gap_before)} to {gap_text(unknown.gap_after)}"
        name = unknown_name(unknown)
        return f"Unexplained by the catalogue: {name} closes the gap of the FRFs from {gaps}."
    if not steps:
        return "Unexplained: no suspect accounts for the difference. Nothing is added to the model."
    verb = "reduces" if len(steps) == 1 else "reduce"
    return f"Unexplained: {effects} {verb} the gap, but may not be present: another effect is missing."


def verdict_text(diagnosis: Diagnosis) -> str:
    """Return the reduction of the gap in a few sentences."""
    remaining = f"{gap_text(diagnosis.remaining_gap)} (random error ± {diagnosis.remaining_scatter:.2f})"
    if diagnosis.verdict is Verdict.NOTHING_MISSING:
        within = ", within their tolerances," if diagnosis.tolerated else ""
        return (
            f"Model and log book{within} predict this test within its random error: the gap is {remaining}."
        )
    if not diagnosis.steps:
        return f"The gap is {remaining}; every suspect was tried at every possible place, and none closes it."
    words = [
        _reduction(diagnosis.steps, tolerated=bool(diagnosis.tolerated)),
        f"The remaining gap over all FRFs is {remaining}.",
    ]
    if diagnosis.verdict in (Verdict.AMBIGUOUS, Verdict.PARTLY_EXPLAINED):
        words += [_equivalents(step) for step in diagnosis.steps if step.rivals_alike]
    return " ".join(words)


def _equivalents(step: Step) -> str:
    equivalents = enumeration([effect_name(effect) for effect in step.rivals_alike], "or")
    return f"This measurement cannot distinguish {effect_name(step.effect)} from {equivalents}."


def _reduction(steps: tuple[Step, ...], *, tolerated: bool) -> str:
    first, last = steps[0], steps[-1]
    subject = "the added effect" if len(steps) == 1 else "the added effects"
    common = tolerated and len(steps) == 1 and first.effect.kind in COMMON_EFFECTS.values()
    if common and first.effect.at is None and first.gap_before - 1 < last.held_out_scatter:
        return (
            f"Tolerances alone leave no gap either ({gap_text(first.gap_before)}), but only if many of them "
            f"are used up in the same direction; {subject} is far more probable."
        )
    return (
        f"With {subject} the gap falls from {gap_text(first.gap_before)} to {gap_text(last.gap_after)}; "
        f"on FRFs that took no part in the fit, from {gap_text(first.held_out_gap_before)} "
        f"to {gap_text(last.held_out_gap_after)} (random error ± {last.held_out_scatter:.2f})."
    )
