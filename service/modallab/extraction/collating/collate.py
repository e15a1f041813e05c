"""Many single-FRF fits made into one consistent set of modes."""

from collections.abc import Mapping, Sequence

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel, Mode, Spread
from modallab.core.wander import Wander, WanderCause
from modallab.correlation.complexity import phase_collinearity
from modallab.extraction.collating.collated_words import (
    choice_of_means,
    no_scale,
    wander_notes,
    why_outlying,
)
from modallab.extraction.collating.driving_point import driving_point_flags
from modallab.extraction.collating.leakage_flag import leakage_flags
from modallab.extraction.collating.means import Averaging, averaged, beyond_chance
from modallab.extraction.collating.scaling import scaled_shapes
from modallab.extraction.collating.wander import UNSEEN, FittedModes, find_wander
from modallab.extraction.singly.fitting import Table

NODE = 3.0  # standard errors: a smaller modal constant may as well be zero
SMALL = 0.02  # and so may one of this part of the largest, which the tails of other modes reach
COMPLEX = 0.9  # phase collinearity: random error of a few per cent leaves more
NOTHING: Mapping[str, str] = {}


def collate(
    table: Table,
    dofs: Sequence[Dof],
    drive: Dof,
    *,
    method: str,
    notes: Sequence[str] = (),
    choices: Mapping[str, str] = NOTHING,
    shared: float = 0.0,
) -> ModalModel:
    """Return modes with their spread over the FRFs and complex shapes.

    On one structure all FRFs have the same poles, and frequency and loss factor are means weighted by one
    over variance, in which no single fit counts beyond its own standard error. Where frequencies wander
    (`find_wander`), each FRF is of a slightly different structure and none is truer than another: the
    means are plain. Standard errors are of these means: from the random error of the lines alone where
    the mean is that of the positions measured (roving mass, steady drift); where the cause is unknown, of
    what other FRFs as many would give, scatter included. The wander itself is in `wander` and in the
    spreads, which are of plain values.

    Shapes are mass-normalised, `phi_j = A_1j / sqrt(A_11)`, the root with its real part positive;
    without a drive-point response they are the modal constants, their largest turned to 1, and
    `normalisation` is "none".

    Parameters
    ----------
    table
        Fits of (n_modes, n_frf), modes in any order; modes that no FRF shows are left out.
    dofs
        Response of each FRF.
    drive
        Where the force acts in all of them.
    method, notes, choices
        What the modal model shall say of how it was made.
    shared
        Correlation of the errors of different FRFs, 0 to 1, from `shared_error`.
    """
    order = _order(table)
    at = drive_row(dofs, drive)
    sense = 1 if at is None else dofs[at].sign * drive.sign
    constant, error = table.modal_constant[order], table.modal_constant_error[order]
    shapes, shape_errors = scaled_shapes(constant, error, at, sense, shared)
    wander = find_wander(
        FittedModes(
            frequency=table.frequency[order],
            frequency_error=table.frequency_error[order],
            loss_factor=table.loss_factor[order],
            good=table.screening.good[order],
            shape=shapes,
            shape_error=shape_errors,
            scaled=at is not None,
        )
    )
    flags = [
        (*_unused(table, int(m), dofs), *_odd(shape, constant[r], error[r], dofs, at, sense))
        for r, (m, shape) in enumerate(zip(order, shapes, strict=True))
    ]
    shown = table.screening.good[order] | table.screening.outlying[order]
    return ModalModel(
        modes=tuple(
            _mode(table, int(m), _averaging(wander, r), shared, shapes[r], shape_errors[r], flags[r])
            for r, m in enumerate(order)
        ),
        dofs=tuple(dofs),
        drive=drive,
        normalisation="none" if at is None else "mass",
        method=method,
        fitted_frequency=np.where(shown, table.frequency[order], np.nan),
        fitted_loss_factor=np.where(shown, table.loss_factor[order], np.nan),
        modal_constant=constant,
        modal_constant_error=error,
        fitted_lines=None if table.lines is None else table.lines[order],
        wander=wander,
        choices={**choices, "means": choice_of_means(wander, shared)},
        notes=(*notes, *no_scale(at, drive), *wander_notes(wander, dofs), *why_outlying(table, order, dofs)),
    )


def drive_row(dofs: Sequence[Dof], drive: Dof) -> int | None:
    """Return which of the FRFs is that of the drive point, None if none is."""
    return next((i for i, dof in enumerate(dofs) if dof.point == drive.point), None)


def _order(table: Table) -> IntArray:
    """Return the modes that some FRF shows, in rising frequency."""
    good = table.screening.good
    seen = np.flatnonzero(good.any(axis=1))
    frequency = [float(table.frequency[m][good[m]].mean()) for m in seen]
    return np.asarray(seen[np.argsort(frequency, kind="stable")], np.int64)


def _averaging(wander: Wander | None, r: int) -> Averaging:
    """Return how frequency and loss factor of a mode are averaged."""
    if wander is None:
        return Averaging.WEIGHTED
    if wander.cause is not WanderCause.UNKNOWN:
        return Averaging.PLAIN
    own = beyond_chance(float(wander.chi_square[r]), int(wander.degrees[r]))
    return Averaging.SCATTERED if own else Averaging.WEIGHTED


def _mode(
    table: Table,
    m: int,
    averaging: Averaging,
    shared: float,
    shape: ComplexArray,
    shape_errors: FloatArray,
    flags: tuple[str, ...],
) -> Mode:
    good = table.screening.good[m]
    frequency, loss_factor = table.frequency[m][good], table.loss_factor[m][good]
    unseen = UNSEEN * float(loss_factor.mean())
    # A fit that came out with little damping states a small error for it: weighted by that, the mean would
    # be too small. Relative errors hardly depend on how the damping came out.
    middle = float(np.median(loss_factor))
    relative = table.loss_factor_error[m][good] / loss_factor * middle
    error, floor = table.frequency_error[m][good], unseen * float(frequency.mean())
    mean = averaged(frequency, error, floor, averaging, shared)
    damping = averaged(
        loss_factor,
        relative if averaging is Averaging.WEIGHTED else table.loss_factor_error[m][good],
        unseen,
        averaging,
        shared,
    )
    return Mode(
        frequency=mean.value,
        loss_factor=damping.value,
        shape=shape,
        frequency_spread=_spread(frequency),
        loss_factor_spread=_spread(loss_factor),
        standard_errors={"frequency": mean.error, "loss_factor": damping.error},
        shape_errors=shape_errors,
        flags=(*flags, *leakage_flags(table, m, mean, damping)),
    )


def _spread(values: FloatArray) -> Spread:
    sd = float(values.std(ddof=1)) if len(values) > 1 else 0.0
    return Spread(float(values.min()), float(values.max()), float(values.mean()), sd, len(values))


def _unused(table: Table, m: int, dofs: Sequence[Dof]) -> list[str]:
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


def _odd(
    shape: ComplexArray,
    constant: ComplexArray,
    error: FloatArray,
    dofs: Sequence[Dof],
    at: int | None,
    sense: int,
) -> list[str]:
    """Return what is unusual about a shape: its drive point, or its phases."""
    flags: list[str] = []
    if at is not None:
        flags += driving_point_flags(complex(constant[at]), float(error[at]), dofs[at], sense)
    if shape.any() and (collinearity := float(phase_collinearity(shape[:, None])[0])) < COMPLEX:
        flags.append(f"complex shape: phase collinearity {collinearity:.2f}")
    return flags
