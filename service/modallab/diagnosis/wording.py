"""What a diagnosis says, in plain words."""

import math

from modallab.core.place import Members, Place
from modallab.diagnosis.result import Alias, Diagnosis, FittedEffect, FittedParameter, Rival, Step, Verdict
from modallab.rig.effect import EFFECTS


def name(effect: FittedEffect | Rival | Alias) -> str:
    """Return kind and place of an effect; what belongs to the whole rig has no place."""
    kind = effect.kind.replace("_", " ")
    if effect.at is None:
        return f"{kind} everywhere" if EFFECTS[effect.kind].structural else kind
    return f"{kind} at {_where(effect.at)}"


def _where(place: Place) -> str:
    if isinstance(place, Members) and len(place.numbers) == 1:
        return f"member {place.numbers[0]}"
    return str(place)


def number(parameter: FittedParameter) -> str:
    """Return a fitted number with its standard error and unit, no more digits than are known."""
    value, error = parameter.value, parameter.standard_error
    unit = "" if parameter.unit == "1" else f" {parameter.unit}"
    if not (math.isfinite(error) and error > 0):
        return f"{value:.6g}{unit}"
    power = math.floor(math.log10(abs(value))) if value else 0
    scale = power if not -3 <= power <= 5 else 0
    digits = max(0, 1 - math.floor(math.log10(error / 10.0**scale)))
    text = f"{value / 10.0**scale:.{digits}f} ± {error / 10.0**scale:.{digits}f}"
    return f"({text})·10^{scale}{unit}" if scale else f"{text}{unit}"


def size(effect: FittedEffect) -> str:
    """Return all fitted numbers of an effect."""
    return ", ".join(f"{key} {number(value)}" for key, value in effect.parameters.items())


def gap(value: float) -> str:
    """Return a gap with three digits, plain."""
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}" if value >= 10 else f"{value:.2f}"


def closing(before: float, after: float) -> str:
    """Return by how much a gap was closed, in one piece."""
    return f"{gap(before)}\N{NO-BREAK SPACE}→\N{NO-BREAK SPACE}{gap(after)}"


def share(probability: float) -> str:
    """Return a probability as a percentage that never claims certainty."""
    if probability > 0.999:
        return "> 99.9 %"
    return "< 0.1 %" if probability < 0.001 else f"{100 * probability:.1f} %"


def headline(diagnosis: Diagnosis) -> str:
    """Return the verdict in one sentence."""
    found = _listed([name(step.effect) for step in diagnosis.steps])
    if diagnosis.verdict is Verdict.NOTHING_MISSING:
        return "Nothing is missing."
    if diagnosis.verdict is Verdict.EXPLAINED:
        return f"Explained. What was missing: {found}."
    if diagnosis.verdict is Verdict.AMBIGUOUS:
        return f"Explained, but not by one cause alone: {found}, or what looks the same."
    if diagnosis.steps:
        return f"Not wholly explained: {found} helps, and something else is left."
    return "Unexplained: no suspect accounts for the difference."


def verdict(diagnosis: Diagnosis) -> str:
    """Return what the gap did, in a few sentences."""
    left = f"{gap(diagnosis.remaining_gap)} (± {diagnosis.remaining_scatter:.2f} by chance)"
    if diagnosis.verdict is Verdict.NOTHING_MISSING:
        return f"Model and log book predict this test as well as its random error allows: the gap is {left}."
    if not diagnosis.steps:
        return f"The gap is {left}; each suspect was fitted everywhere it could be, and none closes it."
    words = [_closing(diagnosis.steps), f"What remains over all FRFs is {left}."]
    if diagnosis.verdict is Verdict.AMBIGUOUS:
        alike = [name(other) for step in diagnosis.steps for other in step.rivals_alike]
        words.append(f"This measurement cannot tell it from {_listed(alike, 'or')}.")
    return " ".join(words)


def _closing(steps: tuple[Step, ...]) -> str:
    first, last = steps[0], steps[-1]
    return (
        f"With it in the prediction the gap falls from {gap(first.gap_before)} to {gap(last.gap_after)}; "
        f"on FRFs that took no part in the fit, from {gap(first.held_out_gap_before)} "
        f"to {gap(last.held_out_gap_after)} (± {last.held_out_scatter:.2f} by chance)."
    )


def _listed(names: list[str], last: str = "and") -> str:
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} {last} {names[-1]}"
