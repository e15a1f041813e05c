"""Matrices of a system with other member matrices."""

import numpy as np
from scipy.sparse import csc_array

from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.fe.cache import Cache, CacheSlot
from modallab.fe.member_table import MemberTable

GROUNDED: CacheSlot[bool] = CacheSlot("grounded")


def grounded(cache: Cache, stiffness: csc_array, table: MemberTable) -> bool:
    """Return whether a matrix (n, n) holds stiffness in addition to that of the members."""

    def make() -> bool:
        ground_stiffness = stiffness - table.sum(table.axial + table.bending, stiffness.shape[0])
        return bool(abs(ground_stiffness).max() > PRODUCT_ROUNDING * abs(stiffness).max())

    return cache.compute(GROUNDED, None, make)


def rebuilt(
    matrices: dict[str, csc_array | None], n: int, old: MemberTable, new: MemberTable
) -> dict[str, csc_array | None]:
    """Return mass, stiffness, damping and viscous, (n, n), in this order, with new member matrices."""
    parts = [dict(zip(matrices, (t.mass, t.axial + t.bending, *t.damping), strict=True)) for t in (old, new)]
    out: dict[str, csc_array | None] = {}
    for name, matrix in matrices.items():
        old_parts, new_parts = (part[name] for part in parts)
        largest = max(np.abs(old_parts).max(), np.abs(new_parts).max())
        if matrix is None and largest == 0:
            out[name] = None
            continue
        if matrix is not None and np.array_equal(old_parts, new_parts):
            out[name] = csc_array(matrix)  # a copy: the new system owns its matrices
            continue
        difference = new.sum(new_parts - old_parts, n)
        total = csc_array(difference if matrix is None else matrix + difference)
        out[name] = total if abs(total).max() > PRODUCT_ROUNDING * largest else None
    return out
