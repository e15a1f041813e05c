"""Matrices of a system whose members are others."""

import numpy as np
from scipy.sparse import csc_array

from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.fe.member_table import MemberTable


def grounded(shared: dict[str, object], stiffness: csc_array, table: MemberTable) -> bool:
    """Return whether a matrix (n, n) holds stiffness beside that of the members; found out once."""
    if "grounded" not in shared:
        ground_stiffness = stiffness - table.sum(table.axial + table.bending, stiffness.shape[0])
        shared["grounded"] = bool(abs(ground_stiffness).max() > PRODUCT_ROUNDING * abs(stiffness).max())
    return shared["grounded"] is True


def rebuilt(
    matrices: dict[str, csc_array | None], n: int, old: MemberTable, new: MemberTable
) -> dict[str, csc_array | None]:
    """Return mass, stiffness, damping and viscous, (n, n) and in this order, of other members."""
    parts = [dict(zip(matrices, (t.mass, t.axial + t.bending, *t.damping), strict=True)) for t in (old, new)]
    out: dict[str, csc_array | None] = {}
    for name, matrix in matrices.items():
        old_parts, new_parts = (part[name] for part in parts)
        largest = max(np.abs(old_parts).max(), np.abs(new_parts).max())
        if matrix is None and largest == 0:
            out[name] = None
            continue
        if matrix is not None and np.array_equal(old_parts, new_parts):
            out[name] = csc_array(matrix)  # the same numbers, but another system's
            continue
        difference = new.sum(new_parts - old_parts, n)
        total = csc_array(difference if matrix is None else matrix + difference)
        out[name] = total if abs(total).max() > PRODUCT_ROUNDING * largest else None
    return out
