"""Many single-FRF fits made into one consistent set of modes."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel, Mode, Spread
from modallab.extraction.fitting import Table

NODE = 3.0  # standard errors: a smaller modal constant may as well be zero
SMALL = 0.02  # and so may one of this part of the largest, which the tails of other modes reach


def collate(
    table: Table, dofs: Sequence[Dof], drive: Dof, *, method: str, notes: Sequence[str] = ()
) -> ModalModel:
    """Return modes with their spread over the FRFs and complex shapes.

    Frequency and loss factor are plain means over the good fits, as each roving position is a slightly
    different structure and none is truer than another; their standard errors hold the random error of the
    lines only, the wander is in the spread. Shapes are mass-normalised, `phi_j = A_1j / sqrt(A_11)`, the
    root with its real part positive; without a drive-point response they are the modal constants, their
    largest turned to 1, and `normalisation` is "none".

    Parameters
    ----------
    table
        Fits of (n_modes, n_frf), modes in any order; modes that no FRF shows are left out.
    dofs
        Response of each FRF.
    drive
        Where the force acts in all of them.
    """
    seen = np.flatnonzero(table.screening.good.any(axis=1))
    frequency = [float(table.frequency[m][table.screening.good[m]].mean()) for m in seen]
    order = seen[np.argsort(frequency, kind="stable")]
    at = drive_row(dofs, drive)
    modes = tuple(_mode(table, int(m), dofs, drive, at) for m in order)
    shown = table.screening.good[order] | table.screening.outlying[order]
    lost = (
        () if at is not None else (f"no response at the drive point {drive}: shapes are not mass-normalised",)
    )
    return ModalModel(
        modes=modes,
        dofs=tuple(dofs),
        normalisation="none" if at is None else "mass",
        method=method,
        fitted_frequency=np.where(shown, table.frequency[order], np.nan),
        fitted_loss_factor=np.where(shown, table.loss_factor[order], np.nan),
        modal_constant=table.modal_constant[order],
        notes=(*notes, *lost),
    )


def drive_row(dofs: Sequence[Dof], drive: Dof) -> int | None:
    """Return which of the FRFs is that of the drive point, None if none is."""
    return next((i for i, dof in enumerate(dofs) if dof.point == drive.point), None)


def _mode(table: Table, m: int, dofs: Sequence[Dof], drive: Dof, at: int | None) -> Mode:
    good = table.screening.good[m]
    frequency, loss_factor = _spread(table.frequency[m], good), _spread(table.loss_factor[m], good)
    constant, error = table.modal_constant[m], table.modal_constant_error[m]
    flags = _flags(table, m, dofs)
    if at is None:
        shape, shape_errors = _unscaled(constant, error)
    else:
        sign = dofs[at].sign * drive.sign
        shape, shape_errors = _mass_normalised(constant, error, at, sign)
        if sign * constant[at].real < 0:
            flags.append(f"drive point {dofs[at]} has a modal constant of the wrong sign")
    return Mode(
        frequency=frequency.mean,
        loss_factor=loss_factor.mean,
        shape=shape,
        frequency_spread=frequency,
        loss_factor_spread=loss_factor,
        standard_errors={
            "frequency": _error_of_mean(table.frequency_error[m], good),
            "loss_factor": _error_of_mean(table.loss_factor_error[m], good),
        },
        shape_errors=shape_errors,
        flags=tuple(flags),
    )


def _spread(values: FloatArray, good: BoolArray) -> Spread:
    kept = values[good]
    sd = float(kept.std(ddof=1)) if len(kept) > 1 else 0.0
    return Spread(float(kept.min()), float(kept.max()), float(kept.mean()), sd, len(kept))


def _error_of_mean(errors: FloatArray, good: BoolArray) -> float:
    return float(np.sqrt((errors[good] ** 2).sum()) / good.sum())


def _flags(table: Table, m: int, dofs: Sequence[Dof]) -> list[str]:
    """Return why an FRF has no part in the means: it contradicts them, or hardly shows the mode."""
    size, error = np.abs(table.modal_constant[m]), table.modal_constant_error[m]
    node = size < np.maximum(NODE * error, SMALL * size.max())
    flags = []
    for j, dof in enumerate(dofs):
        if table.screening.outlying[m, j]:
            flags.append(f"outlier: {dof}")
        elif table.screening.unsure[m, j]:
            flags.append(f"node: {dof}" if node[j] else f"unsure: {dof}")
    return flags


def _mass_normalised(
    constant: ComplexArray, error: FloatArray, at: int, sign: int
) -> tuple[ComplexArray, FloatArray]:
    """Return shape and standard errors; the error of the drive point's constant reaches every component."""
    own = sign * complex(constant[at])
    if own == 0:
        return np.zeros_like(constant), np.zeros_like(error)
    root = np.sqrt(own)
    shape = constant / root
    errors = np.hypot(error / abs(root), np.abs(shape) * error[at] / (2 * abs(own)))
    errors[at] = error[at] / (2 * abs(root))
    return shape, errors


def _unscaled(constant: ComplexArray, error: FloatArray) -> tuple[ComplexArray, FloatArray]:
    largest = constant[np.argmax(np.abs(constant))]
    if largest == 0:
        return np.zeros_like(constant), np.zeros_like(error)
    return constant / largest, error / abs(largest)
