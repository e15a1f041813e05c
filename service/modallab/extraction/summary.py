"""Summaries of the flags on modes and of the notes on an extraction."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from enum import StrEnum

from modallab.core.modal_model import Mode
from modallab.extraction.settings import SUMMARY


class FlagKind(StrEnum):
    """Kinds of flags on modes, those that matter most first; a flag begins with the words of its kind."""

    DOUBLED = "doubled"
    DRIVE_POINT = "drive_point"
    REFERENCES_DIFFER = "references_differ"
    DAMPING_LAW = "damping_law"
    MISFIT = "misfit"
    LEAKAGE_BIAS = "leakage_bias"
    FURTHER_PEAK = "further_peak"
    COMPLEX_SHAPE = "complex_shape"
    COINCIDENT = "coincident"
    PAIR = "pair"
    WINDOW_DAMPING = "window_damping"
    DOUBTFUL_EXPANSION = "doubtful_expansion"
    MERGED = "merged"
    OTHER = "other"
    OUTLIER = "outlier"
    UNSURE = "unsure"
    NODE = "node"


BY_FRF = (FlagKind.OUTLIER, FlagKind.UNSURE, FlagKind.NODE)  # a flag for each FRF, with its name
NOT_MAIN = (FlagKind.MERGED, *BY_FRF)


def flag_kind(flag: str) -> FlagKind:
    """Return the kind of a flag."""
    words = flag.replace(" ", "_")
    if words.startswith("drive_points_differ"):
        return FlagKind.REFERENCES_DIFFER
    return next((kind for kind in FlagKind if words.startswith(kind)), FlagKind.OTHER)


def flag_counts(flags: Iterable[str]) -> dict[str, int]:
    """Return the number of flags by kind, those that matter most first."""
    counts = Counter(map(flag_kind, flags))
    return {kind.value: counts[kind] for kind in FlagKind if kind in counts}


def summarised_flags(flags: Sequence[str]) -> list[str]:
    """Return the flags of a mode, those that matter most first, and one for all FRFs of a kind."""
    by_kind = {kind: [flag for flag in flags if flag_kind(flag) is kind] for kind in FlagKind}
    return [text for kind, texts in by_kind.items() for text in _of_kind(kind, texts)]


def _of_kind(kind: FlagKind, flags: Sequence[str]) -> Sequence[str]:
    if kind not in BY_FRF or len(flags) < 2:
        return flags
    return [f"{kind.value}: {len(flags)} FRFs, such as {flags[0].removeprefix(kind.value).strip(': ')}"]


def main_flags(modes: Sequence[Mode]) -> list[str]:
    """Return the flags that matter most, of different kinds, each with a mode and the number of modes.

    Flags on FRFs that a mean leaves out, and on modes merged by request, are not among them.
    """
    return [text for kind in FlagKind if kind not in NOT_MAIN for text in _main(kind, modes)][: SUMMARY.flags]


def _main(kind: FlagKind, modes: Sequence[Mode]) -> Iterator[str]:
    flagged = [
        (number, flag)
        for number, mode in enumerate(modes, 1)
        for flag in mode.flags
        if flag_kind(flag) is kind
    ]
    numbers = list(dict.fromkeys(number for number, _ in flagged))
    if numbers:
        more = f" ({len(numbers)} modes)" if len(numbers) > 1 else ""
        yield f"mode {numbers[0]}{more}: {flagged[0][1]}"


_VARIABLE = re.compile(r"[-+]?\d[\d.:]*(?:e[-+]?\d+)?(?:[-+][XYZR]+)?", re.IGNORECASE)


def summarised_notes(notes: Sequence[str]) -> list[str]:
    """Return the notes, one of each group that differs in numbers only, with the number of the others."""
    groups: dict[str, list[str]] = {}
    for note in notes:
        groups.setdefault(_VARIABLE.sub("#", note.partition(": ")[0]), []).append(note)
    return [text for group in groups.values() for text in _of_group(group)]


def _of_group(group: list[str]) -> list[str]:
    if len(group) <= SUMMARY.notes_alike:
        return group
    return [f"{group[0]} (and {len(group) - 1} more notes of this kind)"]
