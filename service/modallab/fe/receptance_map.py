"""Receptance of variants of one structure from any DoF to a few fixed motions."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.fe.common_attachments import split_common
from modallab.fe.condensation import condense_if_cheaper
from modallab.fe.settings import CACHE
from modallab.fe.system import DynamicSystem


class ReceptanceMap:
    """Receptances alpha_oB and alpha_BB of variants of one structure, for any columns B.

    Attachments are applied by the Woodbury identity as in `receptance.attached`; all terms that do not
    depend on B are computed once.

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
        self, systems: Sequence[DynamicSystem], omega: FloatArray, outputs_of: Sequence[FloatArray]
    ) -> None:
        common, specific = split_common(systems)
        base = condense_if_cheaper(replace(systems[0], attachments=common))
        self._response = base.base_modes(float(omega.real.max()) / (2 * np.pi)).at(omega)
        variants = [replace(base, attachments=(*base.attachments, *besides)) for besides in specific]
        used: dict[bytes, int] = {}

        def places(block: FloatArray) -> IntArray:
            indices = [used.setdefault(column.tobytes(), len(used)) for column in block.T]
            return np.array(indices, int)

        self._outputs = np.array([places(outputs) for outputs in outputs_of])
        columns_of = [places(variant.stacked_columns) for variant in variants]
        widest = max(len(specific) for specific in columns_of)
        # Padding: a variant with fewer columns has zero stiffness on the additional ones.
        self._attached = np.array([np.pad(specific, (0, widest - len(specific))) for specific in columns_of])
        self._motions = np.array([np.frombuffer(column) for column in used]).T
        z = np.zeros((len(variants), len(omega), widest, widest), complex)
        for total, variant in zip(z, variants, strict=True):
            block = variant.attached_stiffness(omega)
            total[:, : block.shape[1], : block.shape[1]] = block
        self._stiffness = self._effective(z)

    def _effective(self, z: ComplexArray) -> ComplexArray:
        """Return (I + Z alpha_CC)^-1 Z of each variant's attachments, (n_variants, n_freq, R, R), N/m."""
        if not z.shape[-1]:
            return z
        columns, place = np.unique(self._attached, return_inverse=True)
        alpha = self._response.receptance(self._motions[:, columns], self._motions[:, columns])
        place = place.reshape(self._attached.shape)
        within = np.moveaxis(alpha[:, place[:, :, None], place[:, None, :]], 1, 0)
        inner = z @ within
        inner[..., np.arange(z.shape[-1]), np.arange(z.shape[-1])] += 1.0
        return np.asarray(np.linalg.solve(inner, z), complex)

    @cached_property
    def _from_all_dofs(self) -> ComplexArray | None:
        """(n_freq, n_used, n): receptances from all DoFs, None above the memory limit."""
        n = len(self._motions)
        if len(self._response.omega) * self._motions.shape[1] * n > CACHE.receptance_map_values:
            return None
        return self._response.receptance(self._motions, np.eye(n))

    @cached_property
    def _forces(self) -> ComplexArray:
        """(n_variants, n_freq, n_out, R): alpha_oC (I + Z alpha_CC)^-1 Z."""
        motions, place = np.unique(self._attached, return_inverse=True)
        alpha = self._bare(self._motions[:, motions])
        rows, columns = self._outputs[:, :, None], place.reshape(self._attached.shape)[:, None, :]
        return np.asarray(np.moveaxis(alpha[:, rows, columns], 1, 0) @ self._stiffness)

    def _bare(self, columns: FloatArray) -> ComplexArray:
        """Return the receptance (n_freq, n_used, r) from columns, without attachments."""
        from_all_dofs = self._from_all_dofs
        if from_all_dofs is None:
            return self._response.receptance(self._motions, columns)
        rows = np.flatnonzero(columns.any(axis=1))
        return np.asarray(from_all_dofs[:, :, rows] @ columns[rows])

    def to(self, columns: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Return alpha_oB (n_variants, n_freq, n_out, r) and alpha_BB (n_variants, n_freq, r, r), m/N.

        Parameters
        ----------
        columns
            (n, r) motions B.
        """
        bare = np.moveaxis(self._bare(columns), 0, 1)
        outer, within = bare[self._outputs], self._response.receptance(columns, columns)[None]
        outer = outer.swapaxes(1, 2)
        if not self._attached.shape[1]:
            return outer, np.broadcast_to(within, (len(outer), *within.shape[1:]))
        to_attached = bare[self._attached].swapaxes(1, 2)
        to_forces = to_attached.swapaxes(2, 3) @ self._stiffness
        return outer - self._forces @ to_attached, within - to_forces @ to_attached
