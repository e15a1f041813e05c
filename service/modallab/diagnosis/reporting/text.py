"""Statements of a diagnosis in plain English, shared by report and terminal."""

import math
from collections.abc import Mapping, Sequence

from modallab.core.dof import Dof
from modallab.core.place import Channels, Dofs, Members, Place
from modallab.diagnosis.reporting.settings import REPORT
from modallab.diagnosis.result import (
    DetectionLimit,
    EquivalentEffect,
    FittedEffect,
    FittedParameter,
    NextTest,
    Rival,
    Step,
    ToleratedParameter,
)
from modallab.diagnosis.result_localisation import Localisation
from modallab.fe.structure import Structure
from modallab.rig.effect import EFFECTS

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# Changes of a further test, by their names in a request; {} stands for the value.
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


def kind_name(kind: str) -> str:
    """Return the name of a kind of effect in words."""
    return EFFECTS[kind].title or kind.replace("_", " ")


def effect_name(effect: FittedEffect | Rival | EquivalentEffect) -> str:
    """Return kind and place of an effect; an effect of the whole rig has no place."""
    kind, cls = kind_name(effect.kind), EFFECTS[effect.kind]
    if effect.at is None:
        return f"{kind} everywhere" if cls.structural and not cls.title else kind
    if isinstance(effect.at, Channels) and kind.endswith(" channels"):
        return f"{kind.removesuffix(' channels')} {place_name(effect.at)}"
    return f"{kind} {'of' if isinstance(effect.at, Channels) else 'at'} {place_name(effect.at)}"


def place_name(place: Place) -> str:
    """Return a place in words: members and channels by number, DoFs as they are written."""
    if isinstance(place, Members):
        return _counted("member", [str(number) for number in place.numbers])
    if isinstance(place, Channels):
        names = [str(dof) for dof in place.dofs]
        if len(names) > REPORT.most_named:
            return f"{len(names)} channels, {names[0]} to {names[-1]}"
        return _counted("channel", names)
    if isinstance(place, Dofs):
        return enumeration([str(dof) for dof in place.dofs])
    return str(place)


def _counted(noun: str, names: list[str]) -> str:
    return f"{noun}{'s' if len(names) > 1 else ''} {enumeration(names)}"


def place_description(place: Place, structure: Structure) -> str:
    """Return a place as it is found on the structure: a node by its members, a member by its nodes."""
    if isinstance(place, Dof):
        members = [member.number for member in structure.all_members if place.node in member.nodes]
        rotation = place.direction.startswith("R")
        direction = f"in rotation {place.direction[1:]}" if rotation else f"in {place.direction}"
        description = f"node {place.node}, {direction}"
        return f"{description}; {_between(members)}" if members else description
    if isinstance(place, Dofs):
        return "; ".join(place_description(dof, structure) for dof in place.dofs)
    if isinstance(place, Members):
        return "; ".join(
            f"member {number}, between nodes {enumeration([str(n) for n in structure.member(number).nodes])}"
            for number in place.numbers
        )
    if isinstance(place, Channels):
        return place_name(place)
    return "everywhere"


def _between(members: list[int]) -> str:
    if len(members) == 1:
        return f"the end of member {members[0]}"
    return f"between members {enumeration([str(number) for number in members])}"


def number_text(parameter: FittedParameter) -> str:
    """Return a fitted parameter with its standard error and unit, in significant digits."""
    value, error = parameter.value, parameter.standard_error
    unit = _unit_text(parameter.unit)
    if not math.isfinite(value):
        return "needs a level"
    if not (math.isfinite(error) and error > 0):
        return f"{value:.6g}{unit}"
    power = math.floor(math.log10(max(abs(value), error)))
    scale = power if not -3 <= power <= 5 else 0  # range of numbers that are read without an exponent
    digits = max(0, 1 - math.floor(math.log10(error / 10.0**scale)))
    text = f"{value / 10.0**scale:.{digits}f} ± {error / 10.0**scale:.{digits}f}"
    return f"({text})·10{str(scale).translate(SUPERSCRIPTS)}{unit}" if scale else f"{text}{unit}"


def _unit_text(unit: str) -> str:
    """Return a unit as it follows a number, its exponent as a superscript; empty for a ratio."""
    base, _, power = unit.partition("^")
    return "" if unit == "1" else f" {base}{power.translate(SUPERSCRIPTS)}"


def detection_limit_row(limit: DetectionLimit) -> tuple[str, str, str, str]:
    """Return kind and amount of an effect, and its detection limit at two places in words."""
    unit = _unit_text(limit.unit)
    several = limit.at != limit.least_visible_at
    return (
        kind_name(limit.kind),
        limit.parameter.replace("_", " "),
        f"{_in_two_digits(limit.smallest)}{unit}{_at(limit.at)}",
        f"{_in_two_digits(limit.largest)}{unit}{_at(limit.least_visible_at)}" if several else "",
    )


def _in_two_digits(value: float) -> str:
    return f"{float(f'{value:.2g}'):g}"


def _at(place: Place) -> str:
    return "" if place is None else f" ({place_name(place)})"


def tolerated_rows(parameters: Sequence[ToleratedParameter]) -> list[tuple[str, str, str]]:
    """Return name, fitted value and tolerance of nuisance parameters.

    Of the members that share a tolerance only the one that deviates most.
    """
    by_member: dict[str, list[ToleratedParameter]] = {}
    for parameter in parameters:
        if isinstance(parameter.at, Members):
            by_member.setdefault(parameter.name, []).append(parameter)
    rows = [_tolerated_row(p) for p in parameters if not isinstance(p.at, Members)]
    for of_members in by_member.values():
        name, fitted, tolerance = _tolerated_row(max(of_members, key=lambda p: abs(p.value - 1)))
        rows.append((f"{name} (largest of {len(of_members)})", fitted, tolerance))
    return rows


def _tolerated_row(nuisance: ToleratedParameter) -> tuple[str, str, str]:
    """Return name, fitted value and tolerance of a nuisance parameter."""
    name = f"loss factor of mode {nuisance.mode}" if nuisance.mode else nuisance.name.replace("_", " ")
    fitted = number_text(FittedParameter(nuisance.value, nuisance.standard_error, nuisance.unit))
    relative = nuisance.unit == "1"
    tolerance = (
        f"{100 * nuisance.tolerance:.2g} %" if relative else f"{nuisance.tolerance:.2g} {nuisance.unit}"
    )
    place = "" if nuisance.at is None else f", {place_name(nuisance.at)}"
    return f"{name}{place}", fitted, f"± {tolerance}"


def parameter_list(effect: FittedEffect) -> str:
    """Return all fitted parameters of an effect in one line."""
    return ", ".join(f"{name} {text}" for name, text in parameter_rows(effect))


def parameter_rows(effect: FittedEffect) -> list[tuple[str, str]]:
    """Return name and value of each fitted parameter of an effect."""
    return [(name.replace("_", " "), number_text(value)) for name, value in effect.parameters.items()]


def gap_text(value: float) -> str:
    """Return a gap with three significant digits, without an exponent."""
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}" if value >= 10 else f"{value:.2f}"


def gap_reduction(initial: float, final: float) -> str:
    """Return the reduction of a gap, without a line break."""
    return f"{gap_text(initial)}\N{NO-BREAK SPACE}→\N{NO-BREAK SPACE}{gap_text(final)}"


def probability_text(probability: float) -> str:
    """Return a probability in per cent, never 0 or 100 %."""
    if probability > 0.999:
        return "> 99.9 %"
    return "< 0.1 %" if probability < 0.001 else f"{100 * probability:.1f} %"


def probability_statement(step: Step) -> str:
    """Return the probability of a step, and of its most probable rival."""
    probability = f"probability {probability_text(step.probability)}"
    accepted = (step.effect.kind, step.effect.at)
    rivals = [rival for rival in step.rivals if (rival.kind, rival.at) != accepted]
    if not rivals:
        return probability
    best = max(rivals, key=lambda rival: rival.probability)
    return (
        f"{probability}; next best: {effect_name(best)}, {probability_text(best.probability)}, "
        f"with a remaining gap of {gap_text(best.gap_after)}"
    )


def equivalence_statement(step: Step) -> str:
    """Return the effects that this measurement cannot distinguish from the effect of a step."""
    equivalents = enumeration([effect_name(effect) for effect in step.rivals_alike], "or")
    return f"this measurement cannot distinguish it from {equivalents}"


def location_statements(localisation: Localisation) -> list[str]:
    """Return statements on where the model without added effects disagrees with the measurement."""
    lines = []
    if localisation.bands:
        lines.append(f"frequency bands: {enumeration([_band(*band) for band in localisation.bands])}")
    if localisation.modes:
        lines.append(f"elastic modes of the model: {enumeration([str(mode) for mode in localisation.modes])}")
    # If most responses disagree, their list does not locate anything.
    if localisation.dofs and not len(localisation.dofs) > len(localisation.responses) / 2 > 0:
        lines.append(f"responses that disagree most: {enumeration([str(dof) for dof in localisation.dofs])}")
    # Bands, responses and the gap by part are stated elsewhere.
    repeated = ("bands:", "responses:", "mean squared residual")
    return lines + [words for words in localisation.words if not words.startswith(repeated)]


def _band(low: float, high: float) -> str:
    return f"{low:.4g} to {high:.4g} Hz" if high > low else f"{low:.4g} Hz"


def next_test_text(test: NextTest) -> str:
    """Return the proposed further test, its reason, and the effects that it distinguishes."""
    kinds = list(dict.fromkeys(kind_name(kind) for kind in test.separates))
    purpose = f" It distinguishes {enumeration(kinds)}." if kinds else ""
    if len(kinds) == 1:
        purpose = f" It distinguishes one {kinds[0]} from another."
    if math.isfinite(test.expected_separation):
        purpose += f" The expected difference is {gap_text(test.expected_separation)} standard deviations."
    return f"Measure again with {changes_text(test.change)}: {test.why}.{purpose}"


def changes_text(change: Mapping[str, object]) -> str:
    """Return the changes of a further test."""
    return enumeration([_change(key, value) for key, value in change.items()]) or "no change"


def shift_text(value: float, error: float) -> str:
    """Return a relative shift with its standard error in per cent; a dash where it is not known."""
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
        text = enumeration([str(entry) for entry in value])
    else:
        text = str(value).replace("_", " ")
    return CHANGES[key].format(text) if key in CHANGES else f"{key.replace('_', ' ')} {text}"


def enumeration(names: list[str], last: str = "and") -> str:
    """Return names with commas and a last word between."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} {last} {names[-1]}"
