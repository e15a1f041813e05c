"""Receptances of several variants of one structure, as of the runs of a roving test."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.fe.attachment import Attachment, attached_stiffness, merged, stacked_columns, unique_columns
from modallab.fe.common_attachments import split_common
from modallab.fe.condensation import condense_if_cheaper
from modallab.fe.modes import ModalResponse
from modallab.fe.receptance import with_attached_stiffness
from modallab.fe.settings import RECEPTANCE
from modallab.fe.small_systems import solve_small
from modallab.fe.system import DynamicSystem


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
    stacks = [stacked_columns(len(inputs_of[0]), attachments) for attachments in specific]
    widths = [stack.shape[1] for stack in stacks]
    if len(set(widths)) > 1:
        return _by_width(widths, systems, omega, outputs_of, inputs_of)
    loaded = condense_if_cheaper(replace(systems[0], attachments=common), len(omega))
    response = loaded.base_modes(float(omega.real.max()) / (2 * np.pi)).at(omega)
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
    if not any(widths):
        return bare
    z = np.array([attached_stiffness(attachments, response.omega) for attachments in specific])
    return with_attached_stiffness(bare, z)


def _by_width(
    widths: Sequence[int],
    systems: Sequence[DynamicSystem],
    omega: FloatArray,
    outputs_of: Sequence[FloatArray],
    inputs_of: Sequence[FloatArray],
) -> ComplexArray:
    """Return `attached_variants`, those with as many columns of specific attachments together."""
    alpha = np.empty((len(systems), len(omega), outputs_of[0].shape[1], inputs_of[0].shape[1]), complex)
    for width in set(widths):
        alike = [i for i, own in enumerate(widths) if own == width]
        outputs, inputs = ([given[i] for i in alike] for given in (outputs_of, inputs_of))
        alpha[alike] = attached_variants([systems[i] for i in alike], omega, outputs, inputs)
    return alpha


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
