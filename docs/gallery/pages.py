"""Pages of effects, from what their classes say of themselves."""

import inspect
import json
from types import NoneType
from typing import Any

from docs.gallery.curves import TOUCHABLE, effect_body, rig_body, touched
from docs.gallery.example import DESCRIBED, Example
from docs.gallery.examples import GROUPS, example_of, group_of
from docs.gallery.words import HARDWARE, SIMILAR_EFFECTS
from modallab.core.dof import Dof
from modallab.core.place import Channels, Members
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
_NONLINEAR = """`expected` puts the best straight line in the force's place, for a Gaussian motion of the size
that this line itself allows, and adds what the line leaves as a force that is not coherent with the source.
`sampled` steps the force itself through time. They agree to second order. They part where the motion is not
Gaussian: one narrow resonance far into the nonlinearity, jumps between two states of motion, and the scatter
of coherence from record to record."""
_CONVERTED = """`expected` adds to the spectra what the fault leaves on average of signals that are Gaussian.
`sampled` does it to every sample. They part where the signals are not Gaussian, and in the scatter from
record to record."""
_SHAPED = """`expected` works it into the spectra that the lines see, `sampled` into the signal that the
source plays. They differ by random error alone."""
_NOISY = """`expected` adds its power to the auto spectra, `sampled` adds it to every record. They differ
by random error alone."""
_LINEAR = """It is linear: `expected`, `drawn` and `sampled` take the same response at every frequency, and
differ by random error alone."""


def page(kind: str) -> str:
    """Return the page of an effect, Markdown."""
    cls, example = EFFECTS[kind], example_of(kind)
    parts = [
        f"{HEADER}\n# {kind}\n\n{_sentence(cls.summary)}",
        f"![{kind}: the measurement without and with it]({kind}.png)\n\n{_caption(kind, example)}",
        f"## What happens, and the source\n\n{_physics(cls)}",
        f"## Numbers\n\n{parameter_table(cls)}",
        f"## Where it sits\n\n{_where(cls)}",
        f"## How it is declared\n\n{_declared(kind)}",
        f"## On the two routes\n\n{_routes(cls)}",
        f"## What looks like it\n\n{_alike(cls)}",
        "[All effects](README.md)",
    ]
    return "\n\n".join(parts) + "\n"


def index() -> str:
    """Return the gallery's front page, Markdown."""
    parts = [
        f"{HEADER}\n# What a test does to a measurement",
        "One picture an effect: the expected measurement without it in grey, with it in colour, at a"
        "\nbelievable strength. Each links to a page with the equation, its source and its numbers."
        "\nHow they act together: [the virtual rig](../rig.md), [measuring channels](../channels.md).",
    ]
    for group in GROUPS:
        members = [kind for kind in EFFECTS if group_of(kind) == group]
        rows = [
            f"| {_thumbnail(kind)} | [`{kind}`]({kind}.md): {EFFECTS[kind].summary} |" for kind in members
        ]
        parts.append("\n".join([f"## {group}\n", "| | |", "|---|---|", *rows]))
    return "\n\n".join([*parts, f"## What each of them touches\n\n{_overview()}"]) + "\n"


def _overview() -> str:
    """Return which quantities every effect changes, in its picture, as a table."""
    names = [_NAMES[name].removeprefix("the ").removeprefix("its ") for name in TOUCHABLE]
    rows = []
    for kind in EFFECTS:
        changed = touched(kind)
        marks = ["x" if name in changed else "" for name in TOUCHABLE]
        rows.append(f"| [`{kind}`]({kind}.md) | {' | '.join(marks)} |")
    head = f"| effect | {' | '.join(names)} |\n|---{'|---' * len(names)}|"
    note = "By more than 0.2 dB, 1 degree or 0.01 of coherence somewhere in the band of its picture."
    return "\n".join([f"{note}\n\n{head}", *rows])


def parameter_table(cls: type[Effect]) -> str:
    """Return the numbers of an effect as a table."""
    if not cls.specs():
        return "It has none: it is there or not."
    usual = cls(at=None)
    rows = []
    for name, spec in cls.specs().items():
        absent = "-" if spec.absent is None else f"{spec.absent:g}"
        bounds = f"{getattr(usual, name):g} | {spec.lower:g} | {spec.upper:g} | {absent}"
        rows.append(f"| `{name}` | {spec.doc} | {spec.unit} | {bounds} |")
    head = "| name | meaning | unit | default | least | most | absent at |\n|---|---|---|---|---|---|---|"
    return "\n".join([head, *rows])


def _thumbnail(kind: str) -> str:
    return f'<a href="{kind}.md"><img src="{kind}.png" width="320" alt="{kind}"></a>'


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
        f", the source at {' and '.join(f'{level:g} N' for level in example.levels)}"
        if example.levels
        else ""
    )
    added = json.dumps(_added(kind, example))
    return f"{sentence}{common}. The difference is `{added}`{loud}.\n\n{_touches(kind)}"


def _touches(kind: str) -> str:
    changed = touched(kind)
    unchanged = [_NAMES[name] for name in TOUCHABLE if name not in changed]
    sentence = "It changes " + ", ".join(_NAMES[name] for name in changed)
    return f"{sentence}; it leaves {', '.join(unchanged)} as they are." if unchanged else f"{sentence}."


def _added(kind: str, example: Example) -> Any:
    """Return what the second measurement has and the first lacks, as a request writes it."""
    if example.declared is not None:
        return example.declared
    defaults = EFFECTS[kind](at=None).parameters
    return effect_body(kind) | {"parameters": defaults | dict(example.parameters)}


def _physics(cls: type[Effect]) -> str:
    first, _, remainder = inspect.cleandoc(cls.__doc__ or "").replace("<", "\\<").partition("\n")
    return f"> {first}\n\n{remainder.strip()}".strip()


def _where(cls: type[Effect]) -> str:
    at_dof = 'a drive point, `"1:+Y"`' if cls.at_drive else 'a DoF of the structure, `"7:+Y"`'
    names = {
        NoneType: "everywhere, `null`",
        Dof: at_dof,
        Members: 'members, `{"members": [3, 4]}`',
        Channels: 'response channels, `{"channels": ["7:+Y"]}`',
    }
    places = "; ".join(names[place] for place in cls.allowed_places)
    owner = "the structure" if cls.structural else "the rig"
    remark = "" if cls.suspected else " A diagnosis looks for it only when it is named among the suspects."
    return f"`at` is {places}. It belongs to {owner}.{remark}"


def _declared(kind: str) -> str:
    cls, example = EFFECTS[kind], example_of(kind)
    effect = effect_body(kind) | {"parameters": cls(at=None).parameters | dict(example.parameters)}
    body = "a rig's body, a structure's" if cls.structural else "a rig's body"
    request = f"Among the `effects` of {body} or, hidden, of a measurement:\n\n{_json({'effects': [effect]})}"
    if kind not in HARDWARE:
        return request
    return f"By hardware, in the rig's body:\n\n{_json(HARDWARE[kind])}\n\n{request}"


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
    more = " [How a diagnosis tells them apart](../diagnosis.md)."
    return (
        SIMILAR_EFFECTS.get(
            cls.kind, "A diagnosis fits it against all others and lists rivals that are alike."
        )
        + more
    )
