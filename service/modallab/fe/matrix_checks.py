"""Checks of imported matrices, and their slowest motions."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import LinearOperator, SuperLU, eigsh, splu

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import StructureError, bounds
from modallab.fe.settings import EIGENSOLUTION
from modallab.fe.structure_settings import INPUT


def make_symmetric(matrices: FloatArray, labels: Sequence[str], quantity: str) -> None:
    """Make matrices (n, k, k) symmetric to the last digit, in place.

    Raises
    ------
    StructureError
        If one is not symmetric, named by `labels` (n,), or holds a value that is not finite.
    """
    if not np.isfinite(matrices).all():
        i = int(np.argwhere(~np.isfinite(matrices))[0][0])
        raise StructureError(
            f"the {quantity} of {labels[i]} holds a value that is not finite",
            field=quantity,
            value="nan or inf",
        )
    size = np.abs(matrices).max(axis=(1, 2), initial=0.0)
    if (size > INPUT.max_property).any():
        i = int(np.argmax(size))
        raise StructureError(
            f"the {quantity} of {labels[i]} is of no size that can be computed with",
            field=quantity,
            value=float(size[i]),
            allowed=bounds(maximum=INPUT.max_property),
        )
    transposed = matrices.swapaxes(1, 2)
    asymmetry = np.abs(matrices - transposed).max(axis=(1, 2), initial=0.0)
    if (asymmetry > INPUT.max_asymmetry * size).any():
        i = int(np.argmax(asymmetry - INPUT.max_asymmetry * size))
        raise StructureError(
            f"the {quantity} of {labels[i]} is not symmetric",
            field=quantity,
            value=float(asymmetry[i] / size[i]),
            allowed=f"K = K^T to {INPUT.max_asymmetry:g} of the largest entry",
        )
    matrices += transposed.copy()
    matrices /= 2


def check_mass(mass: csc_array, dofs: Sequence[Dof]) -> None:
    """Raise `StructureError` unless a mass matrix (n, n) is positive definite."""
    diagonal = mass.diagonal()
    bare = np.flatnonzero(diagonal < INPUT.min_positive).tolist()
    if bare:
        raise StructureError(
            f"{len(bare)} degrees of freedom carry no mass",
            field="mass",
            value=_listed([dofs[i] for i in bare]),
            allowed="mass or inertia at every one: give them some, or condense them before",
        )
    scale = diags_array(1 / np.sqrt(diagonal))
    factor = _factor(csc_array(scale @ mass @ scale))
    if factor is None or factor.U.diagonal().min() < INPUT.min_mass_pivot:
        raise StructureError(
            "the mass matrix is not positive definite",
            field="mass",
            allowed="some motion without mass, or of negative mass, is none of a structure",
        )


def slowest_motions(mass: csc_array, stiffness: csc_array) -> FloatArray:
    """Return the slowest mass-normalised motions (n, k) of a structure, rigid-body motions among them.

    Raises
    ------
    StructureError
        If the stiffness is negative for some motion.
    """
    n = mass.shape[0]
    count = min(INPUT.rigid_candidates, n)
    # above rounding of the highest eigenvalue, below elastic eigenvalues
    shift = INPUT.rigid_shift * float((abs(stiffness).sum(axis=0) / mass.diagonal()).max()) or 1.0
    factor = _factor(csc_array(stiffness + shift * mass))
    if factor is None or factor.U.diagonal().min() <= 0:
        raise StructureError(
            "the stiffness matrix is negative for some motion",
            field="stiffness",
            allowed="a positive semi-definite matrix",
        )
    if n < EIGENSOLUTION.dense_dofs:
        _, shapes = eigh(stiffness.toarray(), mass.toarray(), subset_by_index=(0, count - 1))
        return np.asarray(shapes)
    inverse = LinearOperator((n, n), matvec=factor.solve, dtype=float)
    # a fixed start: eigsh would draw another one each time
    _, shapes = eigsh(stiffness, count, mass, sigma=-shift, OPinv=inverse, v0=np.ones(n))
    return np.asarray(shapes)


def _factor(matrix: csc_array) -> SuperLU | None:
    """Return L U of a symmetric matrix with diagonal pivots, None where a pivot is zero.

    The signs of the pivots are those of the eigenvalues (Sylvester's law of inertia).
    """
    try:
        factor = splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError:
        return None
    return factor if np.array_equal(factor.perm_r, factor.perm_c) else None


def _listed(dofs: Sequence[Dof]) -> list[str]:
    return [str(dof) for dof in dofs[: INPUT.reported_dofs]]
