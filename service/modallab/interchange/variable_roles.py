"""Roles of the variables of a MATLAB, HDF5 or npz file: which is the frequency axis, which the FRFs."""

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.assumption import Assumption
from modallab.core.errors import InvalidInputError
from modallab.interchange.reading_options import ROLES, ReadingOptions
from modallab.interchange.settings import READING

# Lower case; of a name within a structure, `test.frf`, the last part.
_NAMES = {
    "freq": ("f", "frequency", "frequencies", "freqs", "hz", "freq_hz", "f_hz", "freqvec"),
    "values": (
        "h",
        "frf",
        "frfs",
        "h1",
        "h2",
        "hv",
        "tf",
        "inertance",
        "accelerance",
        "mobility",
        "receptance",
    ),
    "real": ("h_real", "h_re", "frf_real", "frf_re", "re"),
    "imag": ("h_imag", "h_im", "frf_imag", "frf_im", "im"),
    "magnitude": ("mag", "amplitude", "h_mag", "frf_mag", "h_abs"),
    "phase": ("ph", "h_phase", "frf_phase"),
    "coherence": ("coh", "gamma2", "coherences", "cxy", "msc"),
    "outputs": ("output", "responses", "response_dofs", "output_dofs"),
    "inputs": ("input", "references", "reference_dofs", "input_dofs", "excitations"),
    "averages": ("n_averages", "naverages", "navg", "n_avg", "avg"),
}
_PAIRS = (("real", "imag"), ("magnitude", "phase"))


def roles_of(
    arrays: Mapping[str, NDArray[Any]], options: ReadingOptions
) -> tuple[dict[str, str], tuple[Assumption, ...]]:
    """Return the variable of each role, and the roles that were assumed from names or shapes.

    The stated variables come first, then names that are roles, then usual names, then shapes: the one rising
    real vector is the axis, the one complex array with an axis of its length the FRFs.

    Raises
    ------
    InvalidInputError
        If a stated variable is missing, or the roles are not clear; the message names variables, shapes,
        and a proposal.
    """
    absent = [name for name in options.variables.values() if name not in arrays]
    if absent:
        raise InvalidInputError(
            f"the file has no variable {absent[0]!r}, but {_listed(arrays)}",
            field="variables",
            value=absent[0],
            allowed=list(arrays)[: READING.max_listed],
        )
    roles = dict(options.variables)
    roles |= {role: role for role in ROLES if role in arrays and role not in roles}
    certain = set(roles)
    unclear = _by_name(arrays, roles) + _by_shape(arrays, roles)
    if unclear or "freq" not in roles or not _has_values(roles):
        raise _not_clear(arrays, roles, unclear)
    told = {role: name for role, name in roles.items() if role not in certain}
    if not told:
        return roles, ()
    reason = "by names and shapes; `variables` states it"
    return roles, (Assumption("variables", json.dumps(told), reason),)


def _has_values(roles: Iterable[str]) -> bool:
    return "values" in roles or any(set(pair) <= set(roles) for pair in _PAIRS)


def _by_name(arrays: Mapping[str, NDArray[Any]], roles: dict[str, str]) -> list[str]:
    """Add the roles that follow from usual names; return roles that several names have."""
    unclear = []
    for role, names in _NAMES.items():
        redundant = role in ("real", "imag", "magnitude", "phase") and "values" in roles
        if role in roles or redundant:
            continue
        found = [name for name in arrays if _last(name) in (role, *names) and name not in roles.values()]
        if len(found) > 1:
            unclear.append(role)
        elif found:
            roles[role] = found[0]
    return unclear


def _last(name: str) -> str:
    return name.rpartition(".")[2].lower()


def _by_shape(arrays: Mapping[str, NDArray[Any]], roles: dict[str, str]) -> list[str]:
    """Add the roles that follow from shapes; return those that several variables may have."""
    unclear = []
    free = {name: array for name, array in arrays.items() if name not in roles.values()}
    if "freq" not in roles:
        axes = [name for name, array in free.items() if _is_axis(array)]
        if len(axes) == 1:
            roles["freq"] = axes[0]
        elif axes:
            unclear.append("freq")
    if not _has_values(roles) and "freq" in roles:
        n_lines = arrays[roles["freq"]].size
        frfs = [n for n, array in free.items() if array.dtype.kind == "c" and n_lines in array.shape]
        if len(frfs) == 1:
            roles["values"] = frfs[0]
        elif frfs:
            unclear.append("values")
    return unclear


def _is_axis(array: NDArray[Any]) -> bool:
    if array.dtype.kind not in "iuf" or array.size < READING.min_lines or array.size != max(array.shape):
        return False
    axis = array.ravel().astype(float)
    return bool(axis[0] >= 0 and (np.diff(axis) > 0).all())


def _not_clear(
    arrays: Mapping[str, NDArray[Any]], roles: Mapping[str, str], unclear: Sequence[str]
) -> InvalidInputError:
    """Return the error of a file whose variables could be several things, with a proposal."""
    proposed = {role: name for role, name in roles.items() if role in ("freq", "values", "coherence")}
    numbers = [name for name, array in arrays.items() if array.dtype.kind in "iufc"]
    if "freq" not in proposed:
        axes = [name for name in numbers if _is_axis(arrays[name])]
        proposed |= {"freq": axes[0]} if axes else {}
    if not _has_values(roles):
        n_lines = arrays[proposed["freq"]].size if "freq" in proposed else 0
        frfs = [n for n in numbers if n not in proposed.values() and n_lines in arrays[n].shape]
        frfs.sort(key=lambda name: arrays[name].dtype.kind != "c")
        proposed |= {"values": frfs[0]} if frfs else {}
    missing = unclear or [role for role in ("freq", "values") if role not in roles]
    hint = f"; proposed: variables={json.dumps(proposed)}" if proposed else ""
    return InvalidInputError(
        f"which variable is {' and which '.join(missing)} is not clear; it holds {_listed(arrays)}{hint}",
        field="variables",
        value=dict(proposed),
        allowed=list(arrays)[: READING.max_listed],
    )


def _listed(arrays: Mapping[str, NDArray[Any]]) -> str:
    """Return variables with their types and shapes, in words."""
    texts = []
    for name, array in arrays.items():
        kind = "text" if array.dtype.kind in "US" else array.dtype.name
        texts.append(f"{name[:40]} ({kind}, {' x '.join(map(str, array.shape)) or 'one'})")
    more = f" and {len(texts) - READING.max_listed} more" if len(texts) > READING.max_listed else ""
    return (", ".join(texts[: READING.max_listed]) or "no arrays") + more
