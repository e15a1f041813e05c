"""Receptance from anywhere to the same few motions, of variants of one structure: solved for once."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.fe.receptance import condense_if_cheaper, parted
from modallab.fe.settings import CACHE
from modallab.fe.system import DynamicSystem


class ReceptanceMap:
    """Receptances alpha_oB and alpha_BB of variants of one structure, for any columns B.

    What the variants carry is attached by the Woodbury identity, the same as in `receptance.attached`;
    all that does not depend on B is worked out once.

    Parameters
    ----------
    systems
        Variants of the same matrices.
    omega
        (n_freq,) rad/s, above zero.
    lefts
        (n, n_out) motions o of each variant, of one width.
    """

    def __init__(
        self, systems: Sequence[DynamicSystem], omega: FloatArray, lefts: Sequence[FloatArray]
    ) -> None:
        common, own = parted(systems)
        base = condense_if_cheaper(replace(systems[0], attachments=common))
        self._response = base.base_modes(float(omega.max()) / (2 * np.pi)).at(omega)
        variants = [replace(base, attachments=(*base.attachments, *besides)) for besides in own]
        used: dict[bytes, int] = {}

        def places(block: FloatArray) -> IntArray:
            found = [used.setdefault(column.tobytes(), len(used)) for column in block.T]
            return np.array(found, int)

        self._lefts = np.array([places(left) for left in lefts])
        hung = [places(variant.stacked) for variant in variants]
        widest = max(len(own) for own in hung)
        # A variant that carries less is thought to carry nothing on some motion more.
        self._hung = np.array([np.pad(own, (0, widest - len(own))) for own in hung])
        self._used = np.array([np.frombuffer(column) for column in used]).T
        z = np.zeros((len(variants), len(omega), widest, widest), complex)
        for total, variant in zip(z, variants, strict=True):
            block = variant.attached_stiffness(omega)
            total[:, : block.shape[1], : block.shape[1]] = block
        self._stiffness = self._effective(z)

    def _effective(self, z: ComplexArray) -> ComplexArray:
        """Return (I + Z alpha_CC)^-1 Z of what each variant carries, (n_variants, n_freq, R, R), N/m."""
        if not z.shape[-1]:
            return z
        every, where = np.unique(self._hung, return_inverse=True)
        alpha = self._response.receptance(self._used[:, every], self._used[:, every])
        where = where.reshape(self._hung.shape)
        within = np.moveaxis(alpha[:, where[:, :, None], where[:, None, :]], 1, 0)
        inner = z @ within
        inner[..., np.arange(z.shape[-1]), np.arange(z.shape[-1])] += 1.0
        return np.asarray(np.linalg.solve(inner, z), complex)

    @cached_property
    def _everywhere(self) -> ComplexArray | None:
        """(n_freq, n_used, n): from all degrees of freedom, if that is not too much to keep."""
        n = len(self._used)
        if len(self._response.omega) * self._used.shape[1] * n > CACHE.receptance_map_values:
            return None
        return self._response.receptance(self._used, np.eye(n))

    @cached_property
    def _forces(self) -> ComplexArray:
        """(n_variants, n_freq, n_out, R): alpha_oC (I + Z alpha_CC)^-1 Z."""
        every, where = np.unique(self._hung, return_inverse=True)
        alpha = self._bare(self._used[:, every])
        rows, columns = self._lefts[:, :, None], where.reshape(self._hung.shape)[:, None, :]
        return np.asarray(np.moveaxis(alpha[:, rows, columns], 1, 0) @ self._stiffness)

    def _bare(self, columns: FloatArray) -> ComplexArray:
        """Return the receptance (n_freq, n_used, r) from columns, nothing attached."""
        known = self._everywhere
        if known is None:
            return self._response.receptance(self._used, columns)
        rows = np.flatnonzero(columns.any(axis=1))
        return np.asarray(known[:, :, rows] @ columns[rows])

    def to(self, columns: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Return alpha_oB (n_variants, n_freq, n_out, r) and alpha_BB (n_variants, n_freq, r, r), m/N.

        Parameters
        ----------
        columns
            (n, r) motions B.
        """
        bare = np.moveaxis(self._bare(columns), 0, 1)
        outer, within = bare[self._lefts], self._response.receptance(columns, columns)[None]
        outer = outer.swapaxes(1, 2)
        if not self._hung.shape[1]:
            return outer, np.broadcast_to(within, (len(outer), *within.shape[1:]))
        carried = bare[self._hung].swapaxes(1, 2)
        back = carried.swapaxes(2, 3) @ self._stiffness
        return outer - self._forces @ carried, within - back @ carried
