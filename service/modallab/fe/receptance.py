"""Receptance of a system with its attachments: by modes and the Woodbury identity, or directly."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from operator import and_

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.fe.attachment import Attachment, attached_stiffness, merged, stacked_columns, unique_columns
from modallab.fe.cache import CacheSlot
from modallab.fe.modes import ModalResponse
from modallab.fe.settings import CACHE, EIGENSOLUTION, RECEPTANCE
from modallab.fe.system import DynamicSystem

# Columns times frequencies over degrees of freedom, up to which it is cheaper than one solution for modes.
Key = tuple[object, ...]  # of an attachment
FOLDED_SYSTEMS: CacheSlot[DynamicSystem] = CacheSlot("folded systems", CACHE.folded_systems)


def attached(
    response: ModalResponse, system: DynamicSystem, outputs: FloatArray, inputs: FloatArray
) -> ComplexArray:
    """Return the receptance of a system with its attachments, from modes of its matrices alone.

    alpha - alpha B (I + Z B^T alpha B)^-1 Z B^T alpha: exact, and regular where an attachment has
    no stiffness (Woodbury identity).

    Parameters
    ----------
    response
        `system.base_modes(...).at(omega)`.
    outputs, inputs
        (n, n_out) and (n, n_in) motions, unit vectors for single DoFs.

    Returns
    -------
    (n_freq, n_out, n_in), m/N.
    """
    if not system.attachments:
        return response.receptance(outputs, inputs)
    columns = system.stacked_columns
    alpha = response.receptance(np.hstack([outputs, columns]), np.hstack([inputs, columns]))
    return _woodbury(alpha, system.attached_stiffness(response.omega))


def _woodbury(alpha: ComplexArray, z: ComplexArray) -> ComplexArray:
    """Return the receptance with z (..., r, r) attached to the last r rows and columns of alpha."""
    r = z.shape[-1]
    if r == 0:  # attachments without effect have no columns
        return alpha
    to_b, from_b, within = alpha[..., :-r, -r:], alpha[..., -r:, :-r], alpha[..., -r:, -r:]
    if r == 1:  # one division instead of a solver call for every line
        return np.asarray(alpha[..., :-1, :-1] - to_b * (z / (1 + z * within)) * from_b)
    inner = _product(z, within)
    inner[..., np.arange(r), np.arange(r)] += 1.0
    return np.asarray(alpha[..., :-r, :-r] - _product(to_b, solve_small(inner, _product(z, from_b))))


def _product(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    """Return a @ b; over two columns without a call for every line."""
    if a.shape[-1] != 2:
        return np.asarray(a @ b)
    return np.asarray(a[..., 0, None] * b[..., None, 0, :] + a[..., 1, None] * b[..., None, 1, :])


def solve_small(matrix: ComplexArray, loads: ComplexArray) -> ComplexArray:
    """Return the solutions of stacked linear systems; in closed form for up to three unknowns.

    By Cramer's rule: a solver call for every line takes twice as long.
    """
    n = matrix.shape[-1]
    if n == 1:
        return np.asarray(loads / matrix)
    if n > 3:
        return np.asarray(np.linalg.solve(matrix, loads))
    load = [loads[..., i, :] for i in range(n)]
    adjugate: tuple[tuple[ComplexArray, ...], ...]
    if n == 2:
        a, b, c, d = (matrix[..., i, j, None] for i in range(2) for j in range(2))
        adjugate, determinant = ((d, -b), (-c, a)), a * d - b * c
    else:
        a, b, c, d, e, f, g, h, i = (matrix[..., j, k, None] for j in range(3) for k in range(3))
        first = e * i - f * h, f * g - d * i, d * h - e * g
        adjugate = (
            (first[0], c * h - b * i, b * f - c * e),
            (first[1], a * i - c * g, c * d - a * f),
            (first[2], b * g - a * h, a * e - b * d),
        )
        determinant = a * first[0] + b * first[1] + c * first[2]
    rows = [
        sum(factor * part for factor, part in zip(row, load, strict=True)) / determinant for row in adjugate
    ]
    return np.asarray(np.stack(rows, axis=-2))


def attached_variants(
    systems: Sequence[DynamicSystem],
    omega: FloatArray,
    outputs_of: Sequence[FloatArray],
    inputs_of: Sequence[FloatArray],
) -> ComplexArray:
    """Return the receptances of several variants of one structure, (n_variants, n_freq, n_out, n_in), m/N.

    Common attachments are applied once, specific ones variant by variant.

    Parameters
    ----------
    systems
        Variants of the same matrices.
    omega
        (n_freq,) rad/s, above zero.
    outputs_of, inputs_of
        (n, n_out) and (n, n_in) for each variant, of one width each.
    """
    common, parts = split_common(systems)
    specific = _without_repeated_motions(parts)
    loaded = condense_if_cheaper(replace(systems[0], attachments=common), len(omega))
    response = loaded.base_modes(float(omega.real.max()) / (2 * np.pi)).at(omega)
    stacks = [stacked_columns(len(inputs_of[0]), attachments) for attachments in specific]
    widths = {stack.shape[1] for stack in stacks}
    if len(widths) > 1:  # variants of different sizes cannot be stacked
        response = systems[0].base_modes(float(omega.real.max()) / (2 * np.pi)).at(omega)
        variants = zip(systems, outputs_of, inputs_of, strict=True)
        return np.array([attached(response, *variant) for variant in variants])
    columns: dict[bytes, int] = {}

    def places(block: FloatArray) -> list[int]:
        return [columns.setdefault(column.tobytes(), len(columns)) for column in block.T]

    rows = [places(np.hstack([outputs, stack])) for outputs, stack in zip(outputs_of, stacks, strict=True)]
    input_places = [
        places(np.hstack([inputs, stack])) for inputs, stack in zip(inputs_of, stacks, strict=True)
    ]
    motions = np.array([np.frombuffer(column) for column in columns]).T
    a, b = np.broadcast_arrays(np.array(rows)[:, :, None], np.array(input_places)[:, None, :])
    alpha = _attached_pairs(response, loaded, motions, a.ravel(), b.ravel())
    bare = np.moveaxis(alpha.reshape(-1, *a.shape), 0, 1)
    if widths == {0}:
        return bare
    z = np.array([attached_stiffness(attachments, response.omega) for attachments in specific])
    return _woodbury(bare, z)


def _without_repeated_motions(variants: Sequence[tuple[Attachment, ...]]) -> Sequence[tuple[Attachment, ...]]:
    """Return the attachments of each variant, merged where they act on the same motions.

    The Woodbury identity then has fewer unknowns. Variants whose merged attachments differ in their number of
    columns cannot be stacked and stay as they are.
    """
    if len(variants[0]) < 2 or not _repeats_a_motion(variants[0]):
        return variants
    merged_variants = [merged(attachments) for attachments in variants]
    widths = {sum(a.columns.shape[1] for a in attachments) for attachments in merged_variants}
    return merged_variants if len(widths) == 1 else variants


def _repeats_a_motion(attachments: Sequence[Attachment]) -> bool:
    columns = [column.tobytes() for a in attachments for column in a.columns.T]
    return len(set(columns)) < len(columns)


def _attached_pairs(
    response: ModalResponse, system: DynamicSystem, motions: FloatArray, a: IntArray, b: IntArray
) -> ComplexArray:
    """Return receptances between pairs of columns of `motions` (n, .), (n_freq, n_pairs).

    The same as `attached`, evaluated for the given pairs `a`, `b` only.
    """
    if system.stacked_columns.shape[1] > RECEPTANCE.woodbury_columns:
        (rows, row), (columns_used, column) = (np.unique(places, return_inverse=True) for places in (a, b))
        return _attached_to_many(response, system, motions[:, rows], motions[:, columns_used])[:, row, column]
    pairs, place = np.unique(np.sort(np.stack([a, b]), axis=0), axis=1, return_inverse=True)
    a, b = pairs  # receptance is symmetric
    alpha = response.pairs(motions[:, a], motions[:, b])
    columns = system.stacked_columns
    if n_columns := columns.shape[1]:
        grid = np.indices((motions.shape[1], n_columns)).reshape(2, -1)
        to_b = response.pairs(motions[:, grid[0]], columns[:, grid[1]]).reshape(-1, n_columns, alpha.shape[1])
        effective = _effective_stiffness(response, system)
        if n_columns == 1:  # no sums over one
            alpha = alpha - to_b[a, 0] * (effective[0] * to_b[:, 0])[b]
        else:
            forces = (effective * to_b[:, None]).sum(axis=2)
            alpha = alpha - (to_b[a] * forces[b]).sum(axis=1)
    return np.asarray(alpha[place.ravel()].T)


def _attached_to_many(
    response: ModalResponse, system: DynamicSystem, outputs: FloatArray, inputs: FloatArray
) -> ComplexArray:
    """Return `attached` for many columns with repeated motions, (n_freq, n_out, n_in)."""
    attachments = merged(system.attachments)
    n, n_out, n_in = len(outputs), outputs.shape[1], inputs.shape[1]
    motions, place = unique_columns(np.hstack([outputs, inputs, stacked_columns(n, attachments)]))
    alpha = response.between_columns(motions)
    rows, columns, b = np.split(np.array(place), [n_out, n_out + n_in])
    z = attached_stiffness(attachments, response.omega)
    to_b, within, from_b = alpha[:, rows][:, :, b], alpha[:, b][:, :, b], alpha[:, b][:, :, columns]
    inner = _attachment_forces(z, within)
    inner[:, np.arange(len(b)), np.arange(len(b))] += 1.0
    return np.asarray(
        alpha[:, rows][:, :, columns] - to_b @ solve_small(inner, _attachment_forces(z, from_b))
    )


def _attachment_forces(z: ComplexArray, alpha: ComplexArray) -> ComplexArray:
    """Return z @ alpha; elementwise where z (n_freq, r, r) is diagonal, as for masses."""
    if np.count_nonzero(z.any(axis=0)) <= np.count_nonzero(z.diagonal(axis1=1, axis2=2).any(axis=0)):
        return np.asarray(z.diagonal(axis1=1, axis2=2)[..., None] * alpha)
    return np.asarray(z @ alpha)


def _effective_stiffness(response: ModalResponse, system: DynamicSystem) -> ComplexArray:
    """Return (I + Z alpha_BB)^-1 Z of all attachments, (R, R, n_freq), N/m."""
    columns = system.stacked_columns
    z = system.attached_stiffness(response.omega)
    inner = z @ np.ascontiguousarray(response.receptance(columns, columns))
    inner[:, np.arange(z.shape[1]), np.arange(z.shape[1])] += 1.0
    return np.ascontiguousarray(solve_small(inner, z).transpose(1, 2, 0))


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
        _, remaining = _split_by_key(system.attachments, Counter(keys))
        again = replace(folded, attachments=remaining)
        if (
            len(remaining) + len(keys) == len(system.attachments)
            and again.stacked_columns.shape[1] <= RECEPTANCE.woodbury_columns
        ):
            return again
    return None


def split_common(
    systems: Sequence[DynamicSystem],
) -> tuple[tuple[Attachment, ...], list[tuple[Attachment, ...]]]:
    """Return the attachments common to all variants of a structure, and those specific to each."""
    if len(systems) == 1:
        return systems[0].attachments, [()]
    common = reduce(and_, (Counter(a.key for a in s.attachments) for s in systems))
    parts = [_split_by_key(s.attachments, common) for s in systems]
    return parts[0][0], [specific for _, specific in parts]


def _split_by_key(
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


def receptance(
    system: DynamicSystem, freq: FloatArray, outputs: FloatArray, inputs: FloatArray
) -> ComplexArray:
    """Return the receptance (n_freq, n_out, n_in), m/N, at `freq` (n_freq,) Hz, by modal sum."""
    omega = 2 * np.pi * np.asarray(freq, float)
    response = system.base_modes(float(np.max(freq))).at(omega)
    return attached(response, system, outputs, inputs)


def direct_receptance(
    system: DynamicSystem, freq: FloatArray, outputs: FloatArray, inputs: FloatArray
) -> ComplexArray:
    """Return the receptance (n_freq, n_out, n_in), m/N, by a linear solution at every line.

    Slow; the reference for the modal sum.
    """
    folded = system.folded()
    omega = 2 * np.pi * np.asarray(freq, float)

    def dynamic_stiffness(w: float) -> csc_array:
        z = folded.stiffness - w**2 * folded.mass + 0j
        if folded.damping is not None:
            z = z + 1j * folded.damping
        if folded.viscous is not None:
            z = z + 1j * w * folded.viscous
        return csc_array(z)

    if len(system.dofs) < EIGENSOLUTION.dense_dofs:
        stack = np.array([dynamic_stiffness(w).toarray() for w in omega])
        return np.asarray(outputs.T @ np.linalg.solve(stack, inputs.astype(complex)))
    return np.array([outputs.T @ splu(dynamic_stiffness(w)).solve(inputs.astype(complex)) for w in omega])
