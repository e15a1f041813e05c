"""Many single-FRF fits made into one consistent set of modes."""

from collections.abc import Mapping, Sequence

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.frequency_inconsistency import FrequencyInconsistency, InconsistencyCause
from modallab.core.modal_model import ModalModel, Mode, Spread, frf_names
from modallab.extraction.averaging.frequency_inconsistency import (
    UNSEEN,
    FittedModes,
    find_frequency_inconsistency,
)
from modallab.extraction.averaging.leakage_flag import leakage_bias_of, leakage_flags
from modallab.extraction.averaging.means import Averaging, averaged, beyond_chance
from modallab.extraction.averaging.notes import (
    choice_of_means,
    inconsistency_notes,
    no_scale,
    why_outlying,
)
from modallab.extraction.averaging.reference_shapes import ReferenceShapes, reference_shapes
from modallab.extraction.single_mode.fitting import FitTable

NODE = 3.0  # standard errors: a smaller modal constant may as well be zero
SMALL = 0.02  # and so may one of this part of the largest, which the tails of other modes reach
NOTHING: Mapping[str, str] = {}


def combine_fits(
    table: FitTable,
    dofs: Sequence[Dof],
    references: Sequence[Dof],
    *,
    method: str,
    notes: Sequence[str] = (),
    choices: Mapping[str, str] = NOTHING,
    shared: float = 0.0,
) -> ModalModel:
    """Return modes with their spread over the FRFs and complex shapes.

    On one structure all FRFs have the same poles: frequency and loss factor are means weighted by inverse
    variance, in which no single fit counts beyond its own standard error. Where natural frequencies differ
    between FRFs (`find_frequency_inconsistency`), each FRF is of a slightly different structure and the means
    are plain. Standard errors are those of the means: from the random error of the lines alone where the
    cause is known (roving mass, steady drift), else from the scatter over the FRFs. The inconsistency itself
    is in `wander` and in the spreads, which are of unweighted values.

    Shapes are mass-normalised, `phi_j = A_1j / sqrt(A_11)`, the root with its real part positive, or of
    several references as `reference_shapes` has it; without a drive-point response they are the modal
    constants, their largest turned to 1, and `normalisation` is "none".

    Parameters
    ----------
    table
        Fits of (n_modes, n_frf), modes in any order; modes that no FRF shows are left out.
    dofs
        Where the responses are.
    references
        Where forces act; FRFs are counted DoF by DoF, at each of them reference by reference.
    method, notes, choices
        What the modal model shall say of how it was made.
    shared
        Correlation of the errors of different FRFs, 0 to 1, from `shared_error`.
    """
    order = _order(table)
    names, n_ref = frf_names(dofs, references), len(references)
    constant, error = table.modal_constant[order], table.modal_constant_error[order]
    found = reference_shapes(constant, error, dofs, references, shared)
    wander = find_frequency_inconsistency(
        FittedModes(
            frequency=table.frequency[order],
            frequency_error=table.frequency_error[order],
            loss_factor=table.loss_factor[order],
            good=table.screening.good[order],
            shape=found.shape.repeat(n_ref, axis=1),
            shape_error=found.error.repeat(n_ref, axis=1),
            scaled=found.scale is not None,
        )
    )
    shown = table.screening.good[order] | table.screening.outlying[order]
    return ModalModel(
        modes=tuple(
            _mode(table, int(m), _averaging(wander, r), shared, found, r, names) for r, m in enumerate(order)
        ),
        dofs=tuple(dofs),
        references=tuple(references),
        normalisation="none" if found.scale is None else "mass",
        method=method,
        fitted_frequency=np.where(shown, table.frequency[order], np.nan),
        fitted_loss_factor=np.where(shown, table.loss_factor[order], np.nan),
        modal_constant=constant,
        modal_constant_error=error,
        fitted_lines=None if table.lines is None else table.lines[order],
        wander=wander,
        choices={**choices, "means": choice_of_means(wander, shared), **found.said()},
        notes=(
            *notes,
            *no_scale(found),
            *inconsistency_notes(wander, names),
            *why_outlying(table, order, names),
        ),
    )


def _order(table: FitTable) -> IntArray:
    """Return the modes that some FRF shows, in rising frequency."""
    good = table.screening.good
    seen = np.flatnonzero(good.any(axis=1))
    frequency = [float(table.frequency[m][good[m]].mean()) for m in seen]
    return np.asarray(seen[np.argsort(frequency, kind="stable")], np.int64)


def _averaging(wander: FrequencyInconsistency | None, r: int) -> Averaging:
    """Return how frequency and loss factor of a mode are averaged."""
    if wander is None:
        return Averaging.WEIGHTED
    if wander.cause is not InconsistencyCause.UNKNOWN:
        return Averaging.PLAIN
    own = beyond_chance(float(wander.chi_square[r]), int(wander.degrees[r]))
    return Averaging.SCATTERED if own else Averaging.WEIGHTED


def _mode(
    table: FitTable,
    m: int,
    averaging: Averaging,
    shared: float,
    shapes: ReferenceShapes,
    number: int,
    names: Sequence[str],
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
    errors = {"frequency": mean.error, "loss_factor": damping.error}
    bias = leakage_bias_of(table, m)
    return Mode(
        frequency=mean.value,
        loss_factor=damping.value,
        shape=shapes.shape[number],
        frequency_spread=_spread(frequency),
        loss_factor_spread=_spread(loss_factor),
        standard_errors=errors,
        shape_errors=shapes.error[number],
        leakage_bias=bias,
        flags=(
            *_unused(table, m, names),
            *shapes.odd(number),
            *leakage_flags(bias, errors, damping.value),
        ),
    )


def _spread(values: FloatArray) -> Spread:
    sd = float(values.std(ddof=1)) if len(values) > 1 else 0.0
    return Spread(float(values.min()), float(values.max()), float(values.mean()), sd, len(values))


def _unused(table: FitTable, m: int, names: Sequence[str]) -> list[str]:
    """Return why an FRF has no part in the means: it contradicts them, or hardly shows the mode."""
    size, error = np.abs(table.modal_constant[m]), table.modal_constant_error[m]
    node = size < np.maximum(NODE * error, SMALL * size.max())
    flags = []
    for j, name in enumerate(names):
        if table.screening.outlying[m, j]:
            flags.append(f"outlier: {name}")
        elif table.screening.unsure[m, j]:
            flags.append(f"node: {name}" if node[j] else f"unsure: {name}")
    return flags
