"""Pages of effects, from what their classes say of themselves."""

import inspect
import json
from collections.abc import Sequence
from types import NoneType
from typing import Any

from docs.gallery.curves import TOUCHABLE, effect_body, rig_body, touched
from docs.gallery.example import DESCRIBED, Example
from docs.gallery.examples import GROUPS, example_of, group_of
from docs.gallery.words import HARDWARE, SIMILAR_EFFECTS
from modallab.core.dof import Dof
from modallab.core.place import Channels, Dofs, Members
from modallab.rig.effect import EFFECTS, Effect, Stage

HEADER = "<!-- Written by `make docs` from the effect's class and docs/gallery: edit those. -->\n"
_NAMES = {
    "magnitude": "\\|H\\|",
    "phase": "its phase",
    "coherence": "coherence",
    "force": "the force spectrum",
    "response": "the response spectrum",
}
_HOOKS = ("on_motion", "on_spectra", "on_records", "on_source", "on_noise")
_NONLINEAR = """The route `expected` replaces the nonlinear force by its best linear approximation for a
Gaussian motion (equivalent linearisation), whose size follows from the linearised structure, and adds
the remainder of the force as a force that is incoherent with the source. The route `sampled` integrates
the nonlinear force in time. The two agree to second order. They differ where the motion is not Gaussian:
a single narrow resonance with strong nonlinearity, jumps between two states of motion, and the scatter
of coherence from record to record."""
_CONVERTED = """The route `expected` adds the mean influence on Gaussian signals to the spectra; the
route `sampled` changes every sample. The results differ where signals are not Gaussian, and in their
scatter from record to record."""
_SHAPED = """The route `expected` includes the effect in the expected spectra, the route `sampled` includes it
in the signal of the source. The results differ by random error only."""
_NOISY = """The route `expected` adds the power of the noise to the auto spectra, the route `sampled` adds a
random signal to every record. The results differ by random error only."""
_LINEAR = """The effect is linear: the routes `expected`, `drawn` and `sampled` use the same frequency
response, and their results differ by random error only."""


def page(kind: str) -> str:
    """Return the page of an effect, Markdown."""
    cls, example = EFFECTS[kind], example_of(kind)
    parts = [
        f"{HEADER}\n# {kind}\n\n{_sentence(cls.summary)}",
        f"![{kind}: the measurement without and with it]({kind}.png)\n\n{_caption(kind, example)}",
        f"## Equation and source\n\n{_physics(cls)}",
        f"## Parameters\n\n{parameter_table(cls)}",
        f"## Place\n\n{_where(cls)}",
        f"## Declaration\n\n{_declared(kind)}",
        f"## Routes\n\n{_routes(cls)}",
        f"## Similar effects\n\n{_alike(cls)}",
        "[All effects](README.md). [Terms, symbols and short names of sources](../glossary.md).",
    ]
    return "\n\n".join(parts) + "\n"


def index() -> str:
    """Return the gallery's front page, Markdown."""
    parts = [
        f"{HEADER}\n# Effects: influences of rig and structure on a measurement",
        "Terms and symbols: [glossary](../glossary.md).",
        "Each picture shows the expected measurement without the effect in grey and with it in colour, at a"
        "\nrealistic strength. It links to a page with the equation, its source and the parameters."
        "\nEffects in a test: [the virtual rig](../rig.md), [measuring channels](../channels.md).",
    ]
    for group in GROUPS:
        members = [kind for kind in EFFECTS if group_of(kind) == group]
        rows = [
            f"| {_thumbnail(kind)} | [`{kind}`]({kind}.md): {EFFECTS[kind].summary} |" for kind in members
        ]
        parts.append("\n".join([f"## {group}\n", "| | |", "|---|---|", *rows]))
    return "\n\n".join([*parts, f"## Measured quantities that each effect changes\n\n{_overview()}"]) + "\n"


def _overview() -> str:
    """Return which quantities every effect changes, in its picture, as a table."""
    names = [_NAMES[name].removeprefix("the ").removeprefix("its ") for name in TOUCHABLE]
    rows = []
    for kind in EFFECTS:
        changed = touched(kind)
        marks = ["x" if name in changed else "" for name in TOUCHABLE]
        rows.append(f"| [`{kind}`]({kind}.md) | {' | '.join(marks)} |")
    head = f"| effect | {' | '.join(names)} |\n|---{'|---' * len(names)}|"
    note = "Marked: a change of more than 0.2 dB, 1 degree or 0.01 of coherence in the band of the picture."
    return "\n".join([f"{note}\n\n{head}", *rows])


def parameter_table(cls: type[Effect]) -> str:
    """Return the numbers of an effect as a table."""
    if not cls.specs():
        return "None: the effect is present or absent."
    usual = cls(at=None)
    rows = []
    for name, spec in cls.specs().items():
        absent = "-" if spec.absent is None else f"{spec.absent:g}"
        bounds = f"{getattr(usual, name):g} | {spec.lower:g} | {spec.upper:g} | {absent}"
        rows.append(f"| `{name}` | {spec.doc} | {spec.unit} | {bounds} |")
    head = "| name | meaning | unit | default | lower bound | upper bound | absent at |\n" + "|---" * 7 + "|"
    return "\n".join([head, *rows])


def _thumbnail(kind: str) -> str:
    return f'[<img src="{kind}.png" width="320" alt="{kind}">]({kind}.md)'


def _sentence(text: str) -> str:
    return text[0].upper() + text[1:] + "."


def _caption(kind: str, example: Example) -> str:
    rig = rig_body(example)
    lead = example.shows or _sentence(EFFECTS[kind].summary)
    sentence = f"{lead} Shown on {DESCRIBED[example.structure]}, driven at `{rig['drive']}`"
    if len(rig["responses"]) < 5:
        sentence += ", measured at " + ", ".join(f"`{dof}`" for dof in rig["responses"])
    used = {name: value for name, value in example.rig.items() if name not in ("drive", "responses")}
    common = f", with `{json.dumps(used)}` in both" if used else ""
    loud = (
        f"; source level {' and '.join(f'{level:g} N' for level in example.levels)}" if example.levels else ""
    )
    added = json.dumps(_added(kind, example))
    return f"{sentence}{common}. The second measurement adds `{added}`{loud}.\n\n{_touches(kind)}"


def _touches(kind: str) -> str:
    changed = touched(kind)
    unchanged = [_NAMES[name] for name in TOUCHABLE if name not in changed]
    sentence = "The effect changes " + _listed([_NAMES[name] for name in changed])
    return f"{sentence}; it does not change {_listed(unchanged, 'or')}." if unchanged else f"{sentence}."


def _listed(terms: Sequence[str], conjunction: str = "and") -> str:
    """Return terms as a list in words: "a, b and c"."""
    *start, last = terms
    return f"{', '.join(start)} {conjunction} {last}" if start else last


def _added(kind: str, example: Example) -> Any:
    """Return the difference of the two measurements as the body of a request."""
    if example.declared is not None:
        return example.declared
    defaults = EFFECTS[kind](at=None).parameters
    return effect_body(kind) | {"parameters": defaults | dict(example.parameters)}


def _physics(cls: type[Effect]) -> str:
    text = (
        inspect.cleandoc(cls.__doc__ or "").replace("<", "\\<").replace("] [", "] \\[")
    )  # a vector is no link
    first, _, remainder = text.partition("\n")
    return f"> {first}\n\n{remainder.strip()}".strip()


def _where(cls: type[Effect]) -> str:
    at_dof = '`"1:+Y"` (a drive point)' if cls.at_drive else '`"7:+Y"` (a DoF of the structure)'
    names = {
        NoneType: "`null` (everywhere)",
        Dof: at_dof,
        Dofs: '`{"dofs": ["5:+Y", "17:+Y"]}` (DoFs of the structure)',
        Members: '`{"members": [3, 4]}` (members)',
        Channels: '`{"channels": ["7:+Y"]}` (response channels)',
    }
    places = _listed([names[place] for place in cls.allowed_places], "or")
    owner = "the structure" if cls.structural else "the rig"
    remark = "" if cls.suspected else " A diagnosis looks for it only if the request names it in `suspects`."
    return f"The place `at` is {places}. The effect belongs to {owner}.{remark}"


def _declared(kind: str) -> str:
    cls, example = EFFECTS[kind], example_of(kind)
    effect = effect_body(kind) | {"parameters": cls(at=None).parameters | dict(example.parameters)}
    owners = "a rig or of a structure" if cls.structural else "a rig"
    request = (
        f"By name, in `effects` of {owners}; in `effects` of a measurement it is hidden from a diagnosis:"
        f"\n\n{_json({'effects': [effect]})}"
    )
    if kind not in HARDWARE:
        return request
    return f"As hardware, in the request for a rig:\n\n{_json(HARDWARE[kind])}\n\n{request}"


def _json(body: Any) -> str:
    return f"```json\n{json.dumps(body)}\n```"


def _routes(cls: type[Effect]) -> str:
    overridden = {hook for hook in _HOOKS if getattr(cls, hook) is not getattr(Effect, hook)}
    if "on_motion" in overridden:
        return _NONLINEAR
    if overridden & {"on_spectra", "on_records"} and cls.stage >= Stage.ACQUISITION:
        return _CONVERTED
    if "on_source" in overridden:
        return _SHAPED
    return _NOISY if overridden else _LINEAR


def _alike(cls: type[Effect]) -> str:
    more = " [How a diagnosis distinguishes effects](../diagnosis.md)."
    return (
        SIMILAR_EFFECTS.get(
            cls.kind, "A diagnosis fits all suspected effects and lists those that it cannot distinguish."
        )
        + more
    )
