"""Delimited text: csv, tsv, semicolons, analyser exports in columns."""

import re
from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.assumption import Assumption
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.interchange.column_roles import Roles, form_of, roles_of
from modallab.interchange.delimited import Table, read_table
from modallab.interchange.file_content import FileContent, Piece, merged
from modallab.interchange.format import FRF_FORMATS, FrfFormat
from modallab.interchange.header_units import HeaderUnit, header_unit, hertz
from modallab.interchange.points import ends_of_frfs
from modallab.interchange.reading_options import ReadingOptions
from modallab.interchange.settings import TABLE
from modallab.interchange.variables import stated_kind

_BINARY = re.compile(rb"[\x00-\x08\x0e-\x1a\x1c-\x1f]")
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")


def _is_text(head: bytes) -> bool:
    return bool(head.strip()) and (head.startswith(_UTF_16) or _BINARY.search(head) is None)


def _read(piece: Piece, options: ReadingOptions, largest: int) -> FileContent:
    """Return the FRFs of a text in columns."""
    if len(piece.content) > min(largest, TABLE.max_bytes):
        raise InvalidInputError(
            "the text is too large", field="file", value=len(piece.content), allowed=TABLE.max_bytes
        )
    table = read_table(piece.content)
    roles, assumed = roles_of(table, options)
    freq = table.columns[:, roles["freq"][0]].real * hertz(_label(table, roles["freq"][0]))
    curves, form_assumed = _curves(table, roles)
    label = " ".join((*table.names, *table.header[-TABLE.header_looked_at :]))
    labels = [_label(table, index) for index in roles[form_of(roles)[0]]]
    header = HeaderUnit() if options.unit else header_unit(labels)
    kind, kind_assumed = _kind(options, header, label)
    if len(labels) == 1:
        labels = [f"{labels[0]} {' '.join(table.header[-TABLE.header_looked_at :])}"]
    ends, points_assumed = ends_of_frfs(labels, piece.name, piece.number, options)
    coherence = _coherence(table, roles, len(labels))
    contents = [
        FileContent(
            FrfSet(freq, curves[:, [index], None], (output,), (source,), kind),
            None if coherence is None else coherence[:, [index]],
            axis_error=_axis_error(freq),
            assumed=(*assumed, *form_assumed, *kind_assumed, *points_assumed),
        )
        for index, (output, source) in enumerate(_distinct(ends))
    ]
    content = merged(contents)
    if header.unit is None or options.scale != 1.0:  # a stated scale is one to SI
        return content
    return content.scaled(header.unit.response, header.unit.force, header.unit.kind)


def _kind(options: ReadingOptions, header: HeaderUnit, label: str) -> tuple[FrfKind, tuple[Assumption, ...]]:
    """Return the kind of the FRFs, with the assumptions on kind and unit."""
    if header.unit is not None:
        return stated_kind(replace(options, unit=header.text), label)
    kind, assumed = stated_kind(options, label)
    if header.unclear:
        reason = f"the header has [{header.unclear}], which is no motion per force; `unit` states it"
        assumed = tuple(replace(assumption, reason=reason) for assumption in assumed)
    return kind, assumed


def _label(table: Table, index: int) -> str:
    return table.names[index] if table.names else ""


def _distinct(ends: list[tuple[Dof, Dof]]) -> list[tuple[Dof, Dof]]:
    if len(set(ends)) < len(ends):
        twice = next(end for end in ends if ends.count(end) > 1)
        raise InvalidInputError(
            f"two FRFs of the file are {twice[0]} / {twice[1]}: `outputs`, `inputs` or `map` tell them apart",
            field="outputs",
            value=str(twice[0]),
        )
    return ends


def _axis_error(freq: FloatArray) -> float:
    """Return the relative error of frequencies that were rounded to the digits of a text."""
    spacing = np.diff(freq)
    return float(max(TABLE.axis_error, np.ptp(spacing) / freq[-1] if len(spacing) else 0.0))


def _curves(table: Table, roles: Roles) -> tuple[ComplexArray, tuple[Assumption, ...]]:
    """Return the FRFs (n_lines, n_frfs), with the assumptions on their form."""
    form = form_of(roles)
    first = table.columns[:, roles[form[0]]]
    if form == ("values",):
        return first.astype(complex), ()
    second = table.columns[:, roles[form[1]]].real
    if form == ("real", "imag"):
        return first.real + 1j * second, ()
    magnitude, phase_label = first.real, " ".join(_label(table, index) for index in roles["phase"]).lower()
    if re.search(r"\bdb\b", " ".join(_label(table, index) for index in roles["magnitude"]).lower()):
        magnitude = 10 ** (magnitude / 20)
    in_radians = re.search(r"\brad", phase_label) is not None
    phase = second if in_radians else np.radians(second)
    told = in_radians or re.search(r"deg|°", phase_label) is not None
    reason = "the header has no unit of the phase"
    return magnitude * np.exp(1j * phase), () if told else (Assumption("phase", "degrees", reason),)


def _coherence(table: Table, roles: Roles, count: int) -> FloatArray | None:
    columns = roles.get("coherence", [])
    if len(columns) not in (0, count):
        raise InvalidInputError(
            "there are other coherences than FRFs", field="columns", value=len(columns), allowed=count
        )
    return _below_one(table.columns[:, columns].real) if columns else None


def _below_one(coherence: FloatArray) -> FloatArray:
    """Return coherence with the mean of the values that a text rounds to 1 in place of 1.

    A coherence of exactly 1 would have no random error. Where every line has it, nothing was rounded.
    """
    others = coherence[coherence != 1.0]
    for digits in range(1, TABLE.coherence_digits + 1):
        scaled = others * 10.0**digits
        if len(others) and np.abs(scaled - np.rint(scaled)).max() < TABLE.digit_error:
            return np.where(coherence == 1.0, 1.0 - 10.0**-digits / 4, coherence)
    return coherence


FRF_FORMATS.register("delimited_text")(
    FrfFormat("delimited text (csv, tsv, columns)", _is_text, _read, last=True)
)
