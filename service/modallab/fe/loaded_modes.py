"""Resonances of a system with attached masses, springs and dampers, in modal coordinates."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csc_array

from modallab.core.arrays import FloatArray
from modallab.fe.attachment import Attachment
from modallab.fe.modes import ModalBasis


def only_loads(attachments: Sequence[Attachment]) -> bool:
    """Return whether attachments have no internal coordinates and only springs to the ground."""
    return all(a.inner == 0 and (_springs(a) is None or a.columns.shape[1] == 1) for a in attachments)


def _springs(attachment: Attachment) -> FloatArray | None:
    """Return the stiffness of an attachment, None if it has none."""
    return attachment.stiffness if attachment.stiffness is not None and attachment.stiffness.any() else None


def loaded_modes(basis: ModalBasis, attachments: Sequence[Attachment]) -> ModalBasis:
    """Return the elastic modes of a system with attachments that `only_loads`, undamped.

    A spring removes each rigid-body mode that strains it.

    Parameters
    ----------
    basis
        All undamped modes of the system without attachments.
    """
    mass, stiffness = np.eye(len(basis.eigenvalues)), np.diag(basis.eigenvalues.real)
    spring_motions = [np.zeros((basis.n_rigid_body, 0))]
    for a in attachments:
        modal_columns = basis.shapes.real.T @ a.columns
        if a.mass is not None:
            mass += modal_columns @ a.mass @ modal_columns.T
        if (springs := _springs(a)) is not None:
            stiffness += modal_columns @ springs @ modal_columns.T
            spring_motions.append(modal_columns[: basis.n_rigid_body])
    values, rotation = eigh(stiffness, mass, check_finite=False)
    elastic = slice(basis.n_rigid_body - int(np.linalg.matrix_rank(np.hstack(spring_motions))), None)
    return ModalBasis(values[elastic].astype(complex), basis.shapes.real @ rotation[:, elastic], 0)


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
        Attachments with additional damping.
    """
    shapes, omega = basis.shapes.real, 2 * np.pi * basis.frequencies
    modal_damping = np.zeros(len(omega))
    for name, matrix, speed in (("damping", damping, 1.0), ("viscous", viscous, omega)):
        if matrix is not None:
            modal_damping += speed * (shapes * (matrix @ shapes)).sum(axis=0)
        for a in attachments:
            part = getattr(a, name)
            if part is not None:
                modal_columns = shapes.T @ a.columns
                modal_damping += speed * ((modal_columns @ part) * modal_columns).sum(axis=1)
    moving = omega > 0  # a spring too soft for double precision leaves a motion at 0 Hz
    widths = np.divide(modal_damping, 4 * np.pi * omega, out=np.zeros_like(omega), where=moving)
    return basis.frequencies, widths
