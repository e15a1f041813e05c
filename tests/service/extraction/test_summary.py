"""Summaries of flags and notes: what matters first, and the number of the rest."""

import numpy as np

from modallab.core.modal_model import Mode
from modallab.extraction.summary import (
    FlagKind,
    flag_counts,
    flag_kind,
    main_flags,
    summarised_flags,
    summarised_notes,
)

FLAGS = (
    "node: 5:+Y",
    "node: 7:+Y",
    "outlier: 9:+Y",
    "pair: with 65 Hz",
    "drive point 1:+Y hardly shows the mode",
)


def test_a_flag_begins_with_the_words_of_its_kind() -> None:
    assert flag_kind("complex shape: phase collinearity 0.82") is FlagKind.COMPLEX_SHAPE
    assert flag_kind("drive point 1:+Y has a modal constant of the wrong sign") is FlagKind.DRIVE_POINT
    assert flag_kind("drive points differ by 5 % in the scale of the shape") is FlagKind.REFERENCES_DIFFER
    assert flag_kind("window_damping") is FlagKind.WINDOW_DAMPING
    assert flag_kind("written by an earlier version") is FlagKind.OTHER


def test_every_kind_of_a_flag_is_counted_the_worst_first() -> None:
    counts = flag_counts(FLAGS)
    assert counts == {"drive_point": 1, "pair": 1, "outlier": 1, "node": 2}
    assert list(counts) == ["drive_point", "pair", "outlier", "node"]
    assert sum(counts.values()) == len(FLAGS)


def test_flags_of_many_frfs_become_one() -> None:
    assert summarised_flags(FLAGS) == [
        "drive point 1:+Y hardly shows the mode",
        "pair: with 65 Hz",
        "outlier: 9:+Y",
        "node: 2 FRFs, such as 5:+Y",
    ]


def test_at_most_three_flags_are_named_first_and_none_on_single_frfs() -> None:
    def mode(*flags: str) -> Mode:
        return Mode(20.0, 0.01, np.ones(1, complex), flags=flags)

    modes = [
        mode("node: 5:+Y"),
        mode("pair: a", "misfit: b"),
        mode("misfit: c", "doubled: d", "outlier: 5:+Y"),
    ]
    assert main_flags(modes) == ["mode 3: doubled: d", "mode 2 (2 modes): misfit: b", "mode 2: pair: a"]
    assert main_flags([mode("node: 5:+Y"), mode()]) == []
    assert len(main_flags([mode("doubled: d", "misfit: b", "pair: a", "coincident: e")])) == 3


def test_notes_that_differ_in_numbers_only_are_counted() -> None:
    reasons = [f"mode {n}, {n * 10.5} Hz: stable at {n} of 30 orders" for n in range(1, 14)]
    outliers = [f"mode {n}, 5:+Y left out: +0.2 Hz from the median" for n in range(1, 4)]
    assert summarised_notes(["first", *reasons, *outliers]) == [
        "first",
        f"{reasons[0]} (and 12 more notes of this kind)",
        *outliers,
    ]
