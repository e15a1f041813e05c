"""What a diagnosis says, in plain words."""

import math
from collections.abc import Mapping

from modallab.core.dof import Dof
from modallab.core.place import Channels, Members, Place
from modallab.diagnosis.result import (
    Diagnosis,
    EquivalentEffect,
    FittedEffect,
    FittedParameter,
    Localisation,
    NextTest,
    Rival,
    Step,
    ToleratedParameter,
    Verdict,
)
from modallab.fe.structure import Structure
from modallab.rig.effect import EFFECTS

LITTLE = 0.5  # of what was above 1: left of it, above which nothing is explained
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# What a further test changes, by the contract's name of it; {} stands for the value.
CHANGES = {
    "level_factor": "{} times the force level",
    "averages_factor": "{} times as many averages",
    "n_lines": "{} lines",
    "frequency_max": "frequencies to {} Hz",
    "drive": "the force at {}",
    "responses": "responses at {}",
    "exciter": "a {} as the exciter",
    "excitation": "{} excitation",
    "window": "a {} window",
}


def name(effect: FittedEffect | Rival | EquivalentEffect) -> str:
    """Return kind and place of an effect; what belongs to the whole rig has no place."""
    kind = effect.kind.replace("_", " ")
    if effect.at is None:
        return f"{kind} everywhere" if EFFECTS[effect.kind].structural else kind
    if isinstance(effect.at, Channels) and kind.endswith(" channels"):
        return f"{kind.removesuffix(' channels')} {_where(effect.at)}"
    return f"{kind} {'of' if isinstance(effect.at, Channels) else 'at'} {_where(effect.at)}"


def _where(place: Place) -> str:
    if isinstance(place, Members):
        return _several("member", [str(number) for number in place.numbers])
    if isinstance(place, Channels):
        return _several("channel", [str(dof) for dof in place.dofs])
    return str(place)


def _several(what: str, names: list[str]) -> str:
    return f"{what}{'s' if len(names) > 1 else ''} {_listed(names)}"


def where(place: Place, structure: Structure) -> str:
    """Return a place as one points at it: a node by the members that meet there, a member by its ends."""
    if isinstance(place, Dof):
        meeting = [member.number for member in structure.all_members if place.node in member.nodes]
        way = (
            f"in rotation {place.direction[1:]}"
            if place.direction.startswith("R")
            else f"in {place.direction}"
        )
        return f"node {place.node}, {way}; {_between(meeting)}" if meeting else f"node {place.node}, {way}"
    if isinstance(place, Members):
        return "; ".join(
            f"member {number}, between nodes {_listed([str(n) for n in structure.member(number).nodes])}"
            for number in place.numbers
        )
    if isinstance(place, Channels):
        return _where(place)
    return "everywhere"


def _between(members: list[int]) -> str:
    if len(members) == 1:
        return f"the end of member {members[0]}"
    return f"between members {_listed([str(number) for number in members])}"


def number(parameter: FittedParameter) -> str:
    """Return a fitted number with its standard error and unit, no more digits than are known."""
    value, error = parameter.value, parameter.standard_error
    unit = "" if parameter.unit == "1" else f" {parameter.unit}"
    if not (math.isfinite(error) and error > 0):
        return f"{value:.6g}{unit}"
    power = math.floor(math.log10(max(abs(value), error)))
    scale = power if not -3 <= power <= 5 else 0
    digits = max(0, 1 - math.floor(math.log10(error / 10.0**scale)))
    text = f"{value / 10.0**scale:.{digits}f} ± {error / 10.0**scale:.{digits}f}"
    return f"({text})·10{str(scale).translate(RAISED)}{unit}" if scale else f"{text}{unit}"


def tolerated(one: ToleratedParameter) -> tuple[str, str, str]:
    """Return what may differ a little, what it came to, and its tolerance."""
    what = one.name.replace("_", " ") if one.mode is None else f"loss factor of mode {one.mode}"
    fitted = number(FittedParameter(one.value, one.standard_error, one.unit))
    allowed = f"{one.tolerance:.2g} {one.unit}" if one.unit != "1" else f"{100 * one.tolerance:.2g} %"
    return what if one.at is None else f"{what}, {_where(one.at)}", fitted, f"± {allowed}"


def size(effect: FittedEffect) -> str:
    """Return all fitted numbers of an effect."""
    return ", ".join(f"{key} {text}" for key, text in numbers(effect))


def numbers(effect: FittedEffect) -> list[tuple[str, str]]:
    """Return all fitted numbers of an effect, each with what it is called."""
    return [(key.replace("_", " "), number(value)) for key, value in effect.parameters.items()]


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
    if steps := diagnosis.steps:
        s = "s" if len(steps) == 1 else ""
        if steps[-1].gap_after - 1 > LITTLE * (steps[0].gap_before - 1):
            return f"Unexplained: {found} close{s} little of the gap, and need not be there."
        return f"Not wholly explained: {found} help{s}, and something else is left."
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
        others = [name(other) for step in diagnosis.steps for other in step.rivals_alike]
        words.append(f"This measurement cannot tell it from {_listed(others, 'or')}.")
    return " ".join(words)


def sure(step: Step) -> str:
    """Return how probable a step is, and what comes next."""
    chance = f"{share(step.probability)} of the belief"
    others = [rival for rival in step.rivals if (rival.kind, rival.at) != (step.effect.kind, step.effect.at)]
    if not others:
        return chance
    best = max(others, key=lambda rival: rival.probability)
    return (
        f"{chance}; next {name(best)}, {share(best.probability)}, which leaves a gap of {gap(best.gap_after)}"
    )


def alike(step: Step) -> str:
    """Return what a measurement cannot tell from the effect of a step."""
    others = _listed([name(other) for other in step.rivals_alike], "or")
    return f"this measurement cannot tell it from {others}"


def whereabouts(found: Localisation) -> list[str]:
    """Return in sentences where the model as given parts from the measurement."""
    lines = []
    if found.bands:
        lines.append(f"at {_listed([_band(*band) for band in found.bands])}")
    if found.modes:
        names = [str(mode) for mode in found.modes]
        lines.append(f"at the model's elastic mode{'s' if len(names) > 1 else ''} {_listed(names)}")
    # That most responses disagree tells nothing of where.
    if found.dofs and not len(found.dofs) > len(found.responses) / 2 > 0:
        lines.append(f"most at {_listed([str(dof) for dof in found.dofs])}")
    # Bands, responses and the gap by part are said already.
    said = ("bands:", "responses:", "mean squared residual")
    return lines + [words for words in found.words if not words.startswith(said)]


def _band(low: float, high: float) -> str:
    return f"{low:.4g} to {high:.4g} Hz" if high > low else f"{low:.4g} Hz"


def next_test(test: NextTest) -> str:
    """Return the further measurement that is proposed, why, and what it tells apart."""
    kinds = list(dict.fromkeys(kind.replace("_", " ") for kind in test.separates))
    told = f" It tells {_listed(kinds)} apart." if kinds else ""
    if len(kinds) == 1:
        told = f" It tells one {kinds[0]} from another."
    if math.isfinite(test.expected_separation):
        told += f" Expected is a difference of {gap(test.expected_separation)} standard deviations."
    return f"Measure again with {follow_up(test.change)}: {test.why}.{told}"


def follow_up(change: Mapping[str, object]) -> str:
    """Return what was changed for a further test."""
    return _listed([_change(key, value) for key, value in change.items()]) or "nothing changed"


def shift(value: float, error: float) -> str:
    """Return a share with its standard error in per cent; a dash where it is not known."""
    if not math.isfinite(value):
        return "\N{EM DASH}"
    if not (math.isfinite(error) and error > 0):
        return f"{100 * value:.3g} %"
    digits = max(0, 1 - math.floor(math.log10(100 * error)))
    return f"{100 * value:.{digits}f} ± {100 * error:.{digits}f} %"


def _change(key: str, value: object) -> str:
    if isinstance(value, Mapping) and "mass" in value:
        at = value.get("at", "sensors")
        return f"a known mass of {value['mass']} kg {'on every sensor' if at == 'sensors' else f'at {at}'}"
    if isinstance(value, float):
        text = f"{value:g}"
    elif isinstance(value, (list, tuple)):
        text = _listed([str(one) for one in value])
    else:
        text = str(value).replace("_", " ")
    return CHANGES[key].format(text) if key in CHANGES else f"{key.replace('_', ' ')} {text}"


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
