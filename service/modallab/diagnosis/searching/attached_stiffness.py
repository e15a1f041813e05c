"""Dynamic stiffness that effects attach to a structure, for all values of a kind at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from operator import is_

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.fe.attachment import Attachment, dynamic_stiffnesses
from modallab.rig.effect import Effect
from modallab.rig.run import Run

Attachments = tuple[Attachment, ...]


@dataclass(frozen=True, eq=False)
class _CachedStiffness:
    """Attachments of the first and the last value, and the stiffness of all, in their own coordinates."""

    ends: list[Attachments]
    stiffness: ComplexArray  # (n_variants, n_freq, r, r)

    def matches(self, ends: list[Attachments]) -> bool:
        """Return whether the attachments at another place are equal, but for the motions they act on."""
        return [_signature(attachments) for attachments in ends] == [
            _signature(attachments) for attachments in self.ends
        ]


def _signature(attachments: Attachments) -> list[tuple[object, ...]]:
    return [(a.columns.shape[1], a.inner, *a.key[2:]) for a in attachments]


class AttachedStiffness:
    """Attachments of effects to the structure of a run.

    The stiffness of a kind is cached by its first and last value: at another place with equal attachments
    it differs in the motions it acts on alone. Members of different matrices have different attachments.
    """

    def __init__(self, run: Run, omega: FloatArray) -> None:
        self._run, self._omega = run, omega
        self._cache: dict[object, _CachedStiffness] = {}

    def of(self, variants: Sequence[Effect]) -> tuple[FloatArray, ComplexArray] | None:
        """Return motions (n, r) and the dynamic stiffness of each value, (n_variants, n_freq, r, r).

        None if a value changes the structure in another way. No motions if no value attaches anything.

        Parameters
        ----------
        variants
            One kind of effect at one place, in several sizes.
        """
        ends = [self._attachments(effect) for effect in (variants[0], variants[-1])]
        first, last = ends
        if first is None or last is None:
            return None
        name = variants[0].kind, tuple(tuple(variant.parameters.items()) for variant in variants)
        cached = self._cache.get(name)
        if cached is None or not cached.matches([first, last]):
            attachments = [
                first,
                *map(self._attachments, variants[1:-1]),
                *([last] if len(variants) > 1 else []),
            ]
            complete = [variant for variant in attachments if variant is not None]
            if len(complete) < len(attachments):
                return None
            if not any(complete):
                n = len(variants), len(self._omega)
                return np.zeros((self._run.system.mass.shape[0], 0)), np.zeros((*n, 0, 0), complex)
            if not _equal_motions(complete):
                columns = _span(np.hstack([a.columns for variant in complete for a in variant]))
                return columns, np.array([self._stiffness(variant, columns) for variant in complete])
            cached = self._cache[name] = _CachedStiffness([first, last], self._block_diagonal(complete))
        columns = np.hstack([a.columns for a in first])
        basis = _span(columns)
        if basis.shape[1] == columns.shape[1]:
            return columns, cached.stiffness
        transformation = basis.T @ columns
        return basis, transformation @ cached.stiffness @ transformation.T

    def _attachments(self, effect: Effect) -> Attachments | None:
        """Return the attachments of an effect; None if it changes the structure in any other way."""
        system, modified = self._run.system, effect.on_system(self._run.system, self._run.acquisition_run)
        if modified.mass is not system.mass or modified.stiffness is not system.stiffness:
            return None
        n = len(system.attachments)
        extended = len(modified.attachments) >= n and all(map(is_, system.attachments, modified.attachments))
        return modified.attachments[n:] if extended else None

    def _block_diagonal(self, variants: Sequence[Attachments]) -> ComplexArray:
        """Return the stiffness of values with equal motions, in the coordinates of these side by side."""
        blocks = [dynamic_stiffnesses(sizes, self._omega) for sizes in zip(*variants, strict=True)]
        if len(blocks) == 1:
            return blocks[0]
        r = sum(block.shape[-1] for block in blocks)
        block_matrix = np.zeros((len(variants), len(self._omega), r, r), complex)
        start = 0
        for block in blocks:
            stop = start + block.shape[-1]
            block_matrix[..., start:stop, start:stop] = block
            start = stop
        return block_matrix

    def _stiffness(self, attachments: Attachments, basis: FloatArray) -> ComplexArray:
        """Return the stiffness of attachments in a basis (n, r) of their motions, (n_freq, r, r)."""
        total = np.zeros((len(self._omega), basis.shape[1], basis.shape[1]), complex)
        for a in attachments:
            transformation = basis.T @ a.columns
            total += transformation @ a.dynamic_stiffness(self._omega) @ transformation.T
        return total


def _equal_motions(variants: Sequence[Attachments]) -> bool:
    """Return whether all values act on the same motions, with as many coordinates."""
    first = variants[0]
    return all(
        len(variant) == len(first)
        and all(
            a.inner == b.inner and np.array_equal(a.columns, b.columns)
            for a, b in zip(variant, first, strict=True)
        )
        for variant in variants[1:]
    )


def _span(columns: FloatArray) -> FloatArray:
    """Return an orthonormal basis (n, r) of columns that may be linearly dependent."""
    if columns.shape[1] == 1:
        return np.asarray(columns / np.linalg.norm(columns))
    sides, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(sides[:, sizes > COMPARISON_ROUNDING * sizes[0]])
