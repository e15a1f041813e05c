"""What sizes of an effect hang on a structure, all at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from operator import is_

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.fe.attachment import Attachment, dynamic_stiffnesses
from modallab.rig.effect import Effect
from modallab.rig.run import Run

ROUNDING = 1e-9  # of the largest singular value

Own = tuple[Attachment, ...]


@dataclass(frozen=True, eq=False)
class _Known:
    """The first and the last of some sizes, and the stiffness of all, in the terms of their own motions."""

    ends: list[Own]
    stiffness: ComplexArray  # (n_variants, n_freq, r, r)

    def same(self, ends: list[Own]) -> bool:
        """Return whether elsewhere the same hangs there, but for the motions that it hangs on."""
        return [_numbers(own) for own in ends] == [_numbers(own) for own in self.ends]


def _numbers(own: Own) -> list[tuple[object, ...]]:
    return [(a.columns.shape[1], a.inner, *a.key[2:]) for a in own]


class AttachedStiffness:
    """What effects hang on the structure of a run.

    Of a kind at many places the first and the last size tell whether those between are known from before:
    what a size hangs there depends on the place by its motions and, of a member, by its own matrices.
    """

    def __init__(self, run: Run, omega: FloatArray) -> None:
        self._run, self._omega = run, omega
        self._before: dict[object, _Known] = {}

    def of(self, variants: Sequence[Effect]) -> tuple[FloatArray, ComplexArray] | None:
        """Return motions (n, r) and the dynamic stiffness of each size there, (n_variants, n_freq, r, r).

        None if one does anything else to the structure, or nothing hangs there at all.

        Parameters
        ----------
        variants
            One kind of effect at one place, in several sizes.
        """
        ends = [self._hung(effect) for effect in (variants[0], variants[-1])]
        first, last = ends
        if first is None or last is None:
            return None
        name = variants[0].kind, tuple(tuple(one.parameters.items()) for one in variants)
        known = self._before.get(name)
        if known is None or not known.same([first, last]):
            hung = [first, *map(self._hung, variants[1:-1]), *([last] if len(variants) > 1 else [])]
            own = [one for one in hung if one is not None]
            if len(own) < len(hung) or not any(own):
                return None
            if not _alike(own):
                columns = _span(np.hstack([a.columns for one in own for a in one]))
                return columns, np.array([self._stiffness(one, columns) for one in own])
            known = self._before[name] = _Known([first, last], self._together(own))
        columns = np.hstack([a.columns for a in first])
        basis = _span(columns)
        if basis.shape[1] == columns.shape[1]:
            return columns, known.stiffness
        seen = basis.T @ columns
        return basis, seen @ known.stiffness @ seen.T

    def _hung(self, effect: Effect) -> Own | None:
        """Return what an effect attaches to the structure; None if it does anything else to it."""
        before, after = self._run.system, effect.on_system(self._run.system, self._run.acquisition_run)
        if after.mass is not before.mass or after.stiffness is not before.stiffness:
            return None
        n = len(before.attachments)
        kept = len(after.attachments) >= n and all(map(is_, before.attachments, after.attachments))
        return after.attachments[n:] if kept else None

    def _together(self, own: Sequence[Own]) -> ComplexArray:
        """Return the stiffness of sizes that are alike, in the terms of their motions side by side."""
        each = [dynamic_stiffnesses(sizes, self._omega) for sizes in zip(*own, strict=True)]
        if len(each) == 1:
            return each[0]
        r = sum(z.shape[-1] for z in each)
        whole = np.zeros((len(own), len(self._omega), r, r), complex)
        start = 0
        for z in each:
            stop = start + z.shape[-1]
            whole[..., start:stop, start:stop] = z
            start = stop
        return whole

    def _stiffness(self, own: Own, basis: FloatArray) -> ComplexArray:
        """Return the stiffness of attachments in a basis (n, r) of their motions, (n_freq, r, r)."""
        total = np.zeros((len(self._omega), basis.shape[1], basis.shape[1]), complex)
        for a in own:
            seen = basis.T @ a.columns
            total += seen @ a.dynamic_stiffness(self._omega) @ seen.T
        return total


def _alike(own: Sequence[Own]) -> bool:
    """Return whether sizes hang on the same motions, with as many coordinates."""
    first = own[0]
    return all(
        len(one) == len(first)
        and all(
            a.inner == b.inner and np.array_equal(a.columns, b.columns)
            for a, b in zip(one, first, strict=True)
        )
        for one in own[1:]
    )


def _span(columns: FloatArray) -> FloatArray:
    """Return an orthonormal basis (n, r) of columns that may be many times the same few."""
    if columns.shape[1] == 1:
        return np.asarray(columns / np.linalg.norm(columns))
    sides, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(sides[:, sizes > ROUNDING * sizes[0]])
