"""Degrees of freedom from the names that other programs write: `5:+Y`, `12Z`, `wing_tip`, `H 5X/1X`."""

import re
from collections.abc import Mapping, Sequence

from modallab.core.assumption import Assumption
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.interchange.reading_options import ReadingOptions

DEFAULT_DIRECTION = "Z"
_DIRECTION = r"([+-]?)(R?[XYZ])([+-]?)"
_IN_TEXT = re.compile(rf"(?<![0-9.A-Za-z])([0-9]{{1,9}})\s?[:_ ]?{_DIRECTION}(?![A-Za-z0-9])", re.IGNORECASE)
_WHOLE = re.compile(rf"\s*([0-9]{{1,9}})\s*[:_ .]?\s*(?:{_DIRECTION})?\s*", re.IGNORECASE)
_TAIL = re.compile(rf"[\s:_.]*{_DIRECTION}\s*", re.IGNORECASE)


def dof_of(name: str, names: Mapping[str, str]) -> tuple[Dof, bool] | None:
    """Return the DoF that a name stands for, and whether its direction is assumed; None where it is none.

    Parameters
    ----------
    name
        A whole name: `5:+Y`, `5Y`, `5 Y+`, `5`, or one of `names`, also followed by a direction.
    names
        DoFs or nodes by name.
    """
    text = name.strip()
    if text in names:
        return _parsed(names[text])
    for known in sorted(names, key=len, reverse=True):
        tail = _TAIL.fullmatch(text[len(known) :]) if text.startswith(known) else None
        if tail is not None:
            mapped = _parsed(names[known])
            return None if mapped is None else (_dof(mapped[0].node, tail[2], tail[1] or tail[3]), False)
    return _parsed(text)


def _parsed(text: str) -> tuple[Dof, bool] | None:
    match = _WHOLE.fullmatch(text)
    if match is None:
        return None
    if match[3] is None:
        return Dof(int(match[1]), DEFAULT_DIRECTION), True
    return _dof(int(match[1]), match[3], match[2] or match[4]), False


def _dof(node: int, direction: str, sign: str) -> Dof:
    return Dof(node, direction.upper(), -1 if sign == "-" else 1)


def dofs_in(label: str, names: Mapping[str, str]) -> list[Dof]:
    """Return the DoFs that a longer text names: of `FRF 5:+Y / 1:+Y` two, of `real 5Y` one."""
    found: list[tuple[int, Dof]] = []
    for known in sorted(names, key=len, reverse=True):
        whole_word = re.compile(rf"(?<![0-9A-Za-z]){re.escape(known)}(?:{_TAIL.pattern})?(?![0-9A-Za-z])")
        for match in whole_word.finditer(label):
            mapped = dof_of(match[0], names)
            if mapped is not None:
                found.append((match.start(), mapped[0]))
        label = whole_word.sub(lambda match: "\0" * len(match[0]), label)
    found += [
        (match.start(), _dof(int(match[1]), match[3], match[2] or match[4]))
        for match in _IN_TEXT.finditer(label)
    ]
    return [dof for _, dof in sorted(found, key=lambda place: place[0])]


def named_dofs(
    names: Sequence[str], field: str, options: ReadingOptions
) -> tuple[tuple[Dof, ...], tuple[Assumption, ...]]:
    """Return the DoFs of names in a file, and the directions that had to be assumed.

    Parameters
    ----------
    names
        One name a DoF; empty where the file has none.
    field
        `outputs` or `inputs`, for a refusal.

    Raises
    ------
    InvalidInputError
        If a name is none of a DoF and `map` does not have it.
    """
    dofs, assumed = [], []
    for name in names:
        dof = dof_of(name, options.map)
        if dof is None:
            raise InvalidInputError(
                f"{name[:40]!r} is not a degree of freedom: say which by `map`",
                field=field,
                value=name[:40],
                allowed='node:direction, such as 5:+Y, or map={"name": "12:+Z"}',
            )
        dofs.append(dof[0])
        if dof[1]:
            assumed.append(name)
    if not assumed:
        return tuple(dofs), ()
    reason = f"{', '.join(assumed[:5])} of the file have no direction: `map` or `{field}` tells it"
    return tuple(dofs), (Assumption("directions", f"+{DEFAULT_DIRECTION}", reason),)


def ends_of_frfs(
    labels: Sequence[str], file_name: str, number: int, options: ReadingOptions
) -> tuple[list[tuple[Dof, Dof]], tuple[Assumption, ...]]:
    """Return response and force of each FRF of a file that has only labels.

    `outputs` and `inputs` take precedence over the DoFs in a label, and these over the DoFs in the file's
    name; without any, points are numbered.

    Parameters
    ----------
    labels
        One label an FRF.
    number
        Number of the first FRF where points are numbered.
    """
    ends = [dofs_in(label, options.map) or dofs_in(file_name, options.map) for label in labels]
    if len(labels) > 1 and len(set(map(tuple, ends))) < len(labels):
        ends = [dofs_in(label, options.map) for label in labels]
    stated = [Dof.parse(name, field="outputs") for name in options.outputs]
    forces = [Dof.parse(name, field="inputs") for name in options.inputs]
    assumed: list[Assumption] = []
    responses: list[Dof] = []
    for index, end in enumerate(ends):
        place = number - 1 + index
        if place < len(stated):
            responses.append(stated[place])
        elif end:
            responses.append(end[0])
        else:
            responses.append(Dof(place + 1, DEFAULT_DIRECTION))
            assumed = [_numbered("outputs")]
    sources = []
    for end in ends:
        if len(forces) == 1:
            sources.append(forces[0])
        elif len(end) > 1:
            sources.append(end[1])
        else:
            sources.append(Dof(1, DEFAULT_DIRECTION))
            assumed = [*(a for a in assumed if a.quantity != "inputs"), _only_force()]
    return list(zip(responses, sources, strict=True)), tuple(assumed)


def numbered(count: int, field: str) -> tuple[tuple[Dof, ...], tuple[Assumption, ...]]:
    """Return DoFs for points without names, and that they are assumed."""
    dofs = tuple(Dof(k + 1, DEFAULT_DIRECTION) for k in range(count))
    return dofs, (_only_force() if field == "inputs" and count == 1 else _numbered(field),)


def _numbered(field: str) -> Assumption:
    reason = f"the file does not name them: `{field}` or `map` does"
    return Assumption(field, f"nodes numbered from 1, +{DEFAULT_DIRECTION}", reason)


def _only_force() -> Assumption:
    return Assumption(
        "inputs", f"1:+{DEFAULT_DIRECTION}", "the file does not name the force: `inputs` or `map` does"
    )
