"""Measured modes in the form in which a model is compared with them."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray, frozen
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.modal_model import ModalModel
from modallab.updating.settings import PAIRING


@dataclass(frozen=True, eq=False)
class TargetModes:
    """Measured modes at some DoFs with their errors; complex arrays for damped modes."""

    squares: FloatArray | ComplexArray
    """rad^2/s^2, eigenvalues omega_r^2 (1 + i eta_r) (n_modes,)."""
    shapes: FloatArray | ComplexArray
    """(n_dof, n_modes) mode shapes."""
    dofs: tuple[Dof, ...]
    mass_normalised: bool
    errors: FloatArray | None
    """Standard errors (n_all_rows,): eigenvalues relative to their real part, then shapes; of damped modes
    all real parts, then all imaginary parts.
    """
    n_shapes: int | None = None
    """Lowest modes with rows for shape and eigenvalue, the others for the eigenvalue only; None: all."""

    def __post_init__(self) -> None:
        n, kind = len(self.squares), complex if self.damped else float
        object.__setattr__(self, "squares", frozen(self.squares, kind, (None,), name="frequencies"))
        object.__setattr__(self, "shapes", frozen(self.shapes, kind, (len(self.dofs), n), name="shapes"))
        if self.errors is not None:
            errors = frozen(self.errors, float, (len(self.row_mask),), name="standard_errors")
            object.__setattr__(self, "errors", errors)

    @property
    def damped(self) -> bool:
        """True for modes with loss factors and complex shapes."""
        return np.iscomplexobj(self.squares)

    @property
    def row_mask(self) -> BoolArray:
        """(n_all_rows,) True for the rows that are equations of the update."""
        n = len(self.squares)
        has_shape = np.argsort(np.argsort(self.squares.real)) < (
            n if self.n_shapes is None else self.n_shapes
        )
        rows = np.concatenate([np.ones(n, bool), np.tile(has_shape, len(self.dofs))])
        return np.tile(rows, 2) if self.damped else rows

    @property
    def n_rows(self) -> int:
        """Number of equations."""
        return int(self.row_mask.sum())

    @property
    def frequencies(self) -> FloatArray:
        """(n_modes,) Hz."""
        return np.asarray(np.sqrt(self.squares.real) / (2 * np.pi))

    @property
    def repeated_modes(self) -> tuple[IntArray, ...]:
        """Groups of repeated modes, equal in frequency within their errors.

        Their shapes are any basis of one subspace.
        """
        order = np.argsort(self.squares.real)
        squares, tolerance = self.squares.real[order], np.full(len(order), 2 * PAIRING.repeated_frequency_gap)
        if self.errors is not None:
            tolerance = np.hypot(tolerance, 2 * self.errors[: len(order)][order])  # relative too
        ends = np.flatnonzero(np.diff(squares) > np.maximum(tolerance[1:], tolerance[:-1]) * squares[1:]) + 1
        return tuple(np.sort(group) for group in np.split(order, ends) if len(group) > 1)


def _phase_aligned(shapes: ComplexArray) -> ComplexArray:
    """Return shapes (n_dof, n_modes), each rotated to the phase with the largest real part."""
    return np.asarray(shapes * np.exp(-0.5j * np.angle((shapes**2).sum(axis=0))))


def as_real(shapes: ComplexArray) -> FloatArray:
    """Return the real part of shapes (n_dof, n_modes) after rotation to the phase that makes it largest."""
    return np.asarray(_phase_aligned(shapes).real)


def real_modes(target: ModalModel) -> TargetModes:
    """Return the real modes nearest to measured ones.

    Raises
    ------
    InvalidInputError
        If there is no mode or DoF, a frequency is not above zero, or a shape is zero or far from real.
    """
    _check(target)
    shapes = as_real(target.shapes)
    zero_shapes = np.flatnonzero(~shapes.any(axis=0))
    if zero_shapes.size:
        raise InvalidInputError(
            "a shape is zero", field="shapes", value=int(zero_shapes[0]) + 1, allowed="motion"
        )
    share = _imaginary_share(target)
    if (share > PAIRING.max_imaginary_share).any():
        worst = int(share.argmax())
        raise InvalidInputError(
            f"measured mode {worst + 1} is complex: {share[worst]:.0%} of it moves out of phase",
            field="modes",
            value=worst + 1,
            allowed=f"up to {PAIRING.max_imaginary_share:.0%}: the method is one of real modes",
        )
    return TargetModes(
        squares=(2 * np.pi * target.frequencies) ** 2,
        shapes=shapes,
        dofs=target.dofs,
        mass_normalised=target.normalisation == "mass",
        errors=_errors(target),
    )


def complex_modes(target: ModalModel) -> TargetModes:
    """Return measured modes with their loss factors and complex shapes.

    Raises
    ------
    InvalidInputError
        If there is no mode or DoF, a frequency is not above zero, a shape is zero, or the modes are those
        of an undamped structure.
    """
    _check(target)
    zero_shapes = np.flatnonzero(~target.shapes.any(axis=0))
    if zero_shapes.size:
        raise InvalidInputError(
            "a shape is zero", field="shapes", value=int(zero_shapes[0]) + 1, allowed="motion"
        )
    if not target.loss_factors.any() and not target.shapes.imag.any():
        raise InvalidInputError(
            "the modes are real, without a loss factor or a phase: nothing tells of damping",
            field="loss_factors",
            value=0.0,
            allowed="modes of a damped structure; inverse_eigensensitivity takes real ones",
        )
    squares = np.array([mode.eigenvalue for mode in target.modes])
    return TargetModes(
        squares, target.shapes, target.dofs, target.normalisation == "mass", _damped_errors(target)
    )


def _check(target: ModalModel) -> None:
    if not target.modes or not target.dofs:
        raise InvalidInputError(
            "the modal model is empty", field="modal_model", value=0, allowed=bounds(1, unit="modes")
        )
    frequencies = target.frequencies
    if not (np.isfinite(frequencies) & (frequencies > 0)).all():
        raise InvalidInputError(
            "elastic modes have frequencies above zero",
            field="frequencies",
            value=float(frequencies.min()),
            allowed=bounds(exclusive_minimum=0, unit="Hz"),
        )


def _imaginary_share(target: ModalModel) -> FloatArray:
    """Return the share of each shape that stays imaginary at its best phase, errors deducted (n_modes,)."""
    aligned = _phase_aligned(target.shapes)
    errors = [0.0 if mode.shape_errors is None else (mode.shape_errors**2).sum() for mode in target.modes]
    imaginary_power = np.maximum((aligned.imag**2).sum(axis=0) - np.array(errors), 0.0)
    return np.asarray(np.sqrt(imaginary_power) / np.linalg.norm(aligned, axis=0))


def _errors(target: ModalModel) -> FloatArray | None:
    """Return the standard errors of all rows, None unless the modal model states every one.

    Errors of shapes without a scale are in no unit of a row.
    """
    if target.normalisation != "mass":
        return None
    eigenvalues, shapes = [], []
    for mode in target.modes:
        if "frequency" not in mode.standard_errors or mode.shape_errors is None:
            return None
        eigenvalues.append(2 * mode.standard_errors["frequency"] / mode.frequency)
        shapes.append(mode.shape_errors)
    return np.concatenate([np.array(eigenvalues), np.stack(shapes, axis=1).ravel()])


def _damped_errors(target: ModalModel) -> FloatArray | None:
    """Return the standard errors of all rows, real parts first, None unless every one is stated.

    Real and imaginary part of a shape have the same error.
    """
    real = _errors(target)
    if real is None or not all("loss_factor" in mode.standard_errors for mode in target.modes):
        return None
    n = len(target.modes)
    loss = np.array([mode.standard_errors["loss_factor"] for mode in target.modes])
    # Im lambda = eta omega^2 moves with the frequency too
    imaginary = np.hypot(loss, target.loss_factors * real[:n])
    return np.concatenate([real, imaginary, real[n:]])
