"""Resonances of a system with masses and dampers hung on it, in the coordinates of its own modes."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csc_array

from modallab.core.arrays import FloatArray
from modallab.fe.attachment import Attachment
from modallab.fe.modes import ModalBasis


def only_loads(attachments: Sequence[Attachment]) -> bool:
    """Return whether attachments leave rigid-body modes rigid: no springs, no coordinates of their own."""
    return all(a.inner == 0 and (a.stiffness is None or not a.stiffness.any()) for a in attachments)


def loaded_modes(basis: ModalBasis, attachments: Sequence[Attachment]) -> ModalBasis:
    """Return the elastic modes of a system with attachments that `only_loads`, undamped.

    Parameters
    ----------
    basis
        All undamped modes of the system without them: the same modes as of its matrices, which need
        not be put together again.
    """
    mass = np.eye(len(basis.eigenvalues))
    for a in attachments:
        if a.mass is not None:
            seen = basis.shapes.real.T @ a.columns
            mass += seen @ a.mass @ seen.T
    values, turn = eigh(np.diag(basis.eigenvalues.real), mass, check_finite=False)
    elastic = slice(basis.n_rigid_body, None)
    return ModalBasis(values[elastic].astype(complex), basis.shapes.real @ turn[:, elastic], 0)


def half_power(
    basis: ModalBasis,
    damping: csc_array | None,
    viscous: csc_array | None,
    attachments: Sequence[Attachment] = (),
) -> tuple[FloatArray, FloatArray]:
    """Return frequency and half the half-power bandwidth of undamped elastic modes, (m,) Hz each.

    Parameters
    ----------
    damping, viscous
        Of the system, N/m and N s/m; damping between modes is left out.
    attachments
        What damps it besides.
    """
    shapes, omega = basis.shapes.real, 2 * np.pi * basis.frequencies
    lost = np.zeros(len(omega))
    for name, matrix, speed in (("damping", damping, 1.0), ("viscous", viscous, omega)):
        if matrix is not None:
            lost += speed * (shapes * (matrix @ shapes)).sum(axis=0)
        for a in attachments:
            part = getattr(a, name)
            if part is not None:
                seen = shapes.T @ a.columns
                lost += speed * ((seen @ part) * seen).sum(axis=1)
    return basis.frequencies, lost / (4 * np.pi * omega)
