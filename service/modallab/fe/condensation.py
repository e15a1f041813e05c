"""Attachments folded into the matrices of a structure where that costs less than the Woodbury identity."""

from collections import Counter
from dataclasses import replace

import numpy as np

from modallab.fe.cache import CacheSlot
from modallab.fe.common_attachments import Key, split_by_key
from modallab.fe.settings import CACHE, EIGENSOLUTION, RECEPTANCE
from modallab.fe.system import DynamicSystem

FOLDED_SYSTEMS: CacheSlot[DynamicSystem] = CacheSlot("folded systems", CACHE.folded_systems)


def condense_if_cheaper(system: DynamicSystem, n_freq: float = np.inf) -> DynamicSystem:
    """Return the same system, with many attachments folded into the matrices.

    Solving for the modes again costs less than many attached columns at every one of many frequencies.
    Folded matrices and their modes are cached, and used for systems with a few attachments more.
    Attachments with internal coordinates stay attached, so that rows remain those of the DoFs; those of
    tabulated stiffness too, as no matrix has it; and a few dampers, whose matrix would couple the modes at
    every frequency.

    Parameters
    ----------
    n_freq
        Number of frequency lines of the response: for few of them attachments stay, unless a folded
        system is cached.
    """
    if system.stacked_columns.shape[1] <= RECEPTANCE.woodbury_columns:
        return system
    folded_before = _cached_folding(system)
    if folded_before is not None:
        return folded_before
    if len(system.dofs) < EIGENSOLUTION.dense_dofs and n_freq * _n_motions(
        system
    ) <= RECEPTANCE.woodbury_products_per_dof * len(system.dofs):
        return system
    constant = [a for a in system.attachments if a.is_constant]
    dampers = [a for a in constant if a.viscous is not None]
    few = sum(a.columns.shape[1] for a in dampers) <= RECEPTANCE.woodbury_columns
    plain = tuple(a for a in constant if not few or a not in dampers)
    folded = replace(system, attachments=plain).folded()
    system.cache.compute(FOLDED_SYSTEMS, tuple(a.key for a in plain), lambda: folded)
    return replace(folded, attachments=tuple(a for a in system.attachments if a not in plain))


def _n_motions(system: DynamicSystem) -> int:
    return len({column.tobytes() for column in system.stacked_columns.T})


def _cached_folding(system: DynamicSystem) -> DynamicSystem | None:
    """Return the system with a cached set of its attachments folded, if few others remain."""
    entries: dict[tuple[Key, ...], DynamicSystem] = system.cache.entries(FOLDED_SYSTEMS)
    for keys, folded in reversed(entries.items()):
        _, remaining = split_by_key(system.attachments, Counter(keys))
        again = replace(folded, attachments=remaining)
        if (
            len(remaining) + len(keys) == len(system.attachments)
            and again.stacked_columns.shape[1] <= RECEPTANCE.woodbury_columns
        ):
            return again
    return None
