"""Coincident modes: mass-normalised shapes in the plane that the shapes of equal poles span."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
import scipy.linalg

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.refinement_settings import COINCIDENT_MODES


def coincident_modes(fit: ModalFit) -> list[IntArray]:
    """Return groups of two or more modes whose poles do not differ significantly though their shapes do."""
    if fit.participation is None:
        return []
    width = fit.loss_factor * fit.frequency
    overlapping = np.diff(fit.frequency) < np.minimum(width[1:], width[:-1])  # and not merely vague
    equal_poles = _equal_within_errors(fit.frequency, fit.frequency_error) & _equal_within_errors(
        fit.loss_factor, fit.loss_factor_error
    )
    coincident = overlapping & equal_poles
    bounds = [0, *(np.flatnonzero(~coincident) + 1).tolist(), len(fit.frequency)]
    return [np.arange(a, b) for a, b in pairwise(bounds) if b - a > 1]


def with_reciprocal_shapes(fit: ModalFit, rows: IntArray, senses: IntArray) -> ModalFit:
    """Return the fit with coincident modes that satisfy reciprocity.

    The contribution of such modes to the FRFs is `(Phi Phi_d^T)/(lambda - omega^2)` with their
    mass-normalised shapes Phi and those at the drive points Phi_d; a fit gives it as another product, `Psi
    L`. With `Phi = Psi T` both agree if `T T^T Psi_d^T = L`, by least squares over the drive points. Any
    rotation in the plane is equivalent: the shapes chosen are real where the plane is real, and orthogonal
    over the DoFs. The fit is unchanged if the drive points are too few, or do not determine the plane.

    Parameters
    ----------
    fit
        With participation factors.
    rows
        (n_ref,) index of the DoF at the point of each reference, -1 if there is none.
    senses
        (n_ref,) -1 where both have opposite directions, else 1.
    """
    if fit.participation is None or fit.conditional_error is None:
        return fit
    constant, error = fit.modal_constant.copy(), fit.modal_constant_error.copy()
    reach = fit.participation.copy()
    at = np.flatnonzero(rows >= 0)
    for group in coincident_modes(fit):
        total = constant[group].sum(axis=0).reshape(-1, reach.shape[1])
        shapes = _shapes(total, len(group), rows[at], at, senses[at])
        if shapes is None:
            continue
        reach[group] = np.linalg.lstsq(shapes, total)[0]
        constant[group] = (shapes.T[:, :, None] * reach[group][:, None]).reshape(len(group), -1)
        error[group] = fit.conditional_error[group].max(axis=0)
    return replace(fit, modal_constant=constant, modal_constant_error=error, participation=reach)


def coincidence_flags(fit: ModalFit) -> dict[int, str]:
    """Return the flag of each mode that coincides with another."""
    return {row: text for group in coincident_modes(fit) for row, text in _texts(fit, group)}


def _texts(fit: ModalFit, group: IntArray) -> Iterator[tuple[int, str]]:
    for row in group.tolist():
        neighbours = ", ".join(
            f"{fit.frequency[neighbour]:.5g} Hz" for neighbour in group.tolist() if neighbour != row
        )
        yield (
            row,
            f"coincident: same frequency as {neighbours} within errors; only the shapes' plane is known",
        )


def _equal_within_errors(values: FloatArray, errors: FloatArray) -> BoolArray:
    """Return whether each value and the next do not differ significantly, (n - 1,)."""
    return np.asarray(
        np.abs(np.diff(values)) < COINCIDENT_MODES.pole_errors * np.hypot(errors[1:], errors[:-1])
    )


def _shapes(
    total: ComplexArray, n: int, rows: IntArray, at: IntArray, senses: IntArray
) -> ComplexArray | None:
    """Return n mass-normalised shapes, (n_dof, n), of their sum (n_dof, n_ref); None if not determined."""
    if len(at) < n:
        return None
    plane = _real_basis(np.linalg.svd(total, full_matrices=False)[0][:, :n])
    driven = plane[rows]
    extent = np.linalg.svd(driven, compute_uv=False)
    if extent[-1] < COINCIDENT_MODES.smallest_extent * extent[0]:
        return None
    reach = np.linalg.lstsq(plane, total)[0][:, at] * senses
    square = np.linalg.lstsq(driven, reach.T)[0].T
    shapes = plane @ scipy.linalg.sqrtm((square + square.T) / 2)
    return np.asarray(shapes @ np.linalg.eigh((shapes.conj().T @ shapes).real)[1][:, ::-1])


def _real_basis(basis: ComplexArray) -> ComplexArray:
    """Return an orthonormal basis of the same plane that is real, if there is one.

    A basis `R W` with R real and W unitary has the product `W^T W` of its transpose and itself.
    """
    return np.asarray(basis @ np.linalg.inv(scipy.linalg.sqrtm(basis.T @ basis)))
