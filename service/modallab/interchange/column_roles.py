"""Roles of the columns of a text: frequency, real and imaginary part, magnitude and phase, coherence."""

import re
from collections.abc import Mapping, Sequence

import numpy as np

from modallab.core.assumption import Assumption
from modallab.core.errors import InvalidInputError
from modallab.interchange.delimited import Table
from modallab.interchange.reading_options import ReadingOptions
from modallab.interchange.settings import READING

Roles = dict[str, list[int]]
# In this order: `phase of H (deg)` is no magnitude, `coherence` no FRF.
_PATTERNS = (
    ("coherence", r"coh|gamma"),
    ("phase", r"phase|\bph\b|angle|arg\b|\bdeg|\brad\b|°"),
    ("imag", r"imag|\bim\b|_im\b|\bim_"),
    ("real", r"real|\bre\b|_re\b|\bre_"),
    ("magnitude", r"magn|\bmag\b|_mag|ampl|\babs\b|modulus|\|\s*h\s*\||\bdb\b"),
    ("freq", r"freq|\bhz\b|\bf\b"),
    ("values", r"frf|\bh\d?\b|inertance|accelerance|mobility|receptance"),
)
_COMPATIBLE = (("values",), ("real", "imag"), ("magnitude", "phase"))


def roles_of(table: Table, options: ReadingOptions) -> tuple[Roles, tuple[Assumption, ...]]:
    """Return the columns of each role, with an assumption if they follow from the numbers.

    Raises
    ------
    InvalidInputError
        If a stated column is missing, or the roles are not clear; the message names columns and a proposal.
    """
    if options.columns:
        roles = {role: [_index(name, table) for name in names] for role, names in options.columns.items()}  # type: ignore[union-attr]
        if "freq" not in roles or _form(roles) is None:
            raise _not_clear(table, roles)
        return roles, ()
    roles = _by_name(table.names, table)
    if "freq" in roles and _form(roles) is not None:
        return roles, ()
    guessed = _by_numbers(table)
    if guessed is None or (roles and "freq" not in roles):
        raise _not_clear(table, guessed or roles)
    stated = {role: [index + 1 for index in columns] for role, columns in guessed.items()}
    return guessed, (Assumption("columns", str(stated), "by the numbers in them; `columns` states it"),)


def _form(roles: Mapping[str, Sequence[int]]) -> tuple[str, ...] | None:
    """Return the roles that make FRFs, as many of each; None where there are none."""
    for names in _COMPATIBLE:
        counts = {len(roles.get(name, ())) for name in names}
        if counts and 0 not in counts and len(counts) == 1:
            return names
    return None


def form_of(roles: Roles) -> tuple[str, ...]:
    """Return the roles that make the FRFs: `values`, `real` and `imag`, or `magnitude` and `phase`."""
    return _form(roles) or ()


def _index(name: str | int, table: Table) -> int:
    """Return the index of a column by its name, or its number from 1."""
    n_columns = table.columns.shape[1]
    if isinstance(name, str) and name in table.names:
        return table.names.index(name)
    if str(name).isdecimal() and 1 <= int(name) <= n_columns:
        return int(name) - 1
    close = [index for index, known in enumerate(table.names) if known.startswith(str(name))]
    if len(close) == 1:
        return close[0]
    raise InvalidInputError(
        f"the file has no column {str(name)[:40]!r}, but {_listed(table)}",
        field="columns",
        value=str(name)[:40],
        allowed=[*table.names[: READING.max_listed], f"1 to {n_columns}"],
    )


def _by_name(names: Sequence[str], table: Table) -> Roles:
    """Return the roles that follow from the names of columns."""
    roles: Roles = {}
    for index, name in enumerate(names):
        words = name.lower()
        role = next((role for role, pattern in _PATTERNS if re.search(pattern, words)), None)
        if role is not None:
            roles.setdefault(role, []).append(index)
    if "freq" not in roles and names and names[0].lower() in ("x", "x-axis", "x_value", "x axis"):
        roles["freq"] = [0]
    if "values" in roles and not np.iscomplexobj(table.columns):
        del roles["values"]
    return roles


def _by_numbers(table: Table) -> Roles | None:
    """Return the roles of a rising first column and of pairs of one form after it; None without them."""
    columns = table.columns
    n_columns = columns.shape[1]
    axis = columns[:, 0]
    if axis.imag.any() or axis.real[0] < 0 or not (np.diff(axis.real) > 0).all():
        return None
    if np.iscomplexobj(columns):
        return {"freq": [0], "values": list(range(1, n_columns))}
    curves = columns[:, 1:]
    roles: Roles = {"freq": [0]}
    if (
        n_columns in (4,)
        and curves[:, -1].min() >= 0
        and curves[:, -1].max() <= 1 + READING.coherence_rounding
    ):
        roles["coherence"] = [n_columns - 1]
        curves = curves[:, :-1]
    if curves.shape[1] % 2 or curves.shape[1] == 0:
        return None
    first, second = curves[:, ::2], curves[:, 1::2]
    odd, even = list(range(1, 1 + curves.shape[1], 2)), list(range(2, 2 + curves.shape[1], 2))
    if (first < 0).any(axis=0).all():
        return roles | {"real": odd, "imag": even}
    in_degrees = np.abs(second).max() <= 360 and (np.abs(second).max(axis=0) > 2 * np.pi).all()
    return roles | {"magnitude": odd, "phase": even} if in_degrees else None


def _not_clear(table: Table, roles: Mapping[str, Sequence[int]]) -> InvalidInputError:
    """Return the error of a text whose columns could be several things, with a proposal."""
    proposed = {role: [index + 1 for index in columns] for role, columns in roles.items()}
    if not proposed:
        proposed = {"freq": [1], "real": [2], "imag": [3]}
    return InvalidInputError(
        f"which column is what is not clear: the file has {_listed(table)}; proposed: columns={proposed}",
        field="columns",
        value=dict(proposed),
        allowed="freq with real and imag, magnitude and phase (degrees), or values (complex)",
    )


def _listed(table: Table) -> str:
    """Return the columns in words."""
    n_rows, n_columns = table.columns.shape
    named = ", ".join(f"{i} {name[:30]!r}" for i, name in enumerate(table.names[: READING.max_listed], 1))
    return f"{n_columns} columns of {n_rows} rows" + (f": {named}" if named else "")
