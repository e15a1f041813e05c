"""Attachments that variants of one structure have in common, and those of each variant."""

from collections import Counter
from collections.abc import Sequence
from functools import reduce
from operator import and_

from modallab.fe.attachment import Attachment
from modallab.fe.system import DynamicSystem

Key = tuple[object, ...]  # of an attachment


def split_common(
    systems: Sequence[DynamicSystem],
) -> tuple[tuple[Attachment, ...], list[tuple[Attachment, ...]]]:
    """Return the attachments common to all variants of a structure, and those specific to each."""
    if len(systems) == 1:
        return systems[0].attachments, [()]
    common = reduce(and_, (Counter(a.key for a in s.attachments) for s in systems))
    parts = [split_by_key(s.attachments, common) for s in systems]
    return parts[0][0], [specific for _, specific in parts]


def split_by_key(
    attachments: Sequence[Attachment], keys: Counter[Key]
) -> tuple[tuple[Attachment, ...], tuple[Attachment, ...]]:
    """Return the attachments that match a multiset of keys, and the others."""
    remaining = Counter(keys)
    matching: list[Attachment] = []
    unmatched: list[Attachment] = []
    for attachment in attachments:
        matches = remaining[attachment.key] > 0
        remaining[attachment.key] -= matches
        (matching if matches else unmatched).append(attachment)
    return tuple(matching), tuple(unmatched)
