"""Combination of single-FRF fits into one set of modes."""

from collections.abc import Mapping, Sequence

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.frequency_inconsistency import FrequencyInconsistency, InconsistencyCause
from modallab.core.modal_model import ModalModel, Mode, Spread, frf_names
from modallab.extraction.averaging.frequency_inconsistency import FittedModes, find_frequency_inconsistency
from modallab.extraction.averaging.leakage_flag import leakage_bias_of, leakage_flags
from modallab.extraction.averaging.means import Averaging, Mean, averaged, is_significant
from modallab.extraction.averaging.notes import choice_of_means, inconsistency_notes, no_scale, why_outlying
from modallab.extraction.averaging.reference_shapes import ReferenceShapes, reference_shapes
from modallab.extraction.averaging.settings import INCONSISTENCY, NODES
from modallab.extraction.single_mode.fit_table import FitTable

NO_CHOICES: Mapping[str, str] = {}


def combine_fits(
    table: FitTable,
    dofs: Sequence[Dof],
    references: Sequence[Dof],
    *,
    method: str,
    notes: Sequence[str] = (),
    choices: Mapping[str, str] = NO_CHOICES,
    noise_correlation: FloatArray | float = 0.0,
) -> ModalModel:
    """Return modes with their spread over the FRFs and complex shapes.

    On one structure all FRFs have the same poles: frequency and loss factor are means weighted by inverse
    variance, with Huber weights that bound the influence of a single fit. Where natural frequencies are
    inconsistent (`find_frequency_inconsistency`), each FRF belongs to a slightly different structure and
    means are unweighted. Standard errors are those of the means: from the random error of the lines alone
    where the cause is known (roving mass, steady drift), else from the scatter over the FRFs. The
    inconsistency itself is in `frequency_inconsistency` and in the spreads, which are of unweighted values.

    Shapes are mass-normalised, `phi_j = A_1j / sqrt(A_11)`, the root with its real part positive, or, with
    several references, from `reference_shapes`. Without a drive-point response they are the modal constants
    scaled to a largest component of 1, and `normalisation` is "none".

    Parameters
    ----------
    table
        Fits of (n_modes, n_frf), modes in any order; modes without an accepted fit are left out.
    dofs
        Measured degrees of freedom.
    references
        Reference degrees of freedom; FRFs are ordered by DoF and, for each DoF, by reference.
    method, notes, choices
        Entries of the modal model.
    noise_correlation
        (n_modes,) or for all modes, correlation of the errors of different FRFs, 0 to 1, from
        `shared_noise_fraction`.
    """
    order = _order(table)
    common = np.broadcast_to(noise_correlation, len(table.frequency))
    names = frf_names(dofs, references)
    constant, error = table.modal_constant[order], table.modal_constant_error[order]
    shapes = reference_shapes(constant, error, dofs, references, common[order, None])
    inconsistency = find_frequency_inconsistency(_fitted_modes(table, order, shapes, len(references)))
    identified = table.screening.good[order] | table.screening.outlying[order]
    return ModalModel(
        modes=tuple(
            _mode(table, int(m), _averaging(inconsistency, r), float(common[m]), shapes, r, names)
            for r, m in enumerate(order)
        ),
        dofs=tuple(dofs),
        references=tuple(references),
        normalisation="none" if shapes.scale is None else "mass",
        method=method,
        fitted_frequency=np.where(identified, table.frequency[order], np.nan),
        fitted_loss_factor=np.where(identified, table.loss_factor[order], np.nan),
        modal_constant=constant,
        modal_constant_error=error,
        fitted_lines=None if table.lines is None else table.lines[order],
        frequency_inconsistency=inconsistency,
        choices={
            **choices,
            "means": choice_of_means(inconsistency, common[order]),
            **shapes.choice_text(),
        },
        notes=(*notes, *_notes(table, order, shapes, inconsistency, names)),
    )


def _notes(
    table: FitTable,
    order: IntArray,
    shapes: ReferenceShapes,
    inconsistency: FrequencyInconsistency | None,
    names: Sequence[str],
) -> tuple[str, ...]:
    """Return notes on missing scale, inconsistent frequencies and outlying fits."""
    return (
        *no_scale(shapes),
        *inconsistency_notes(inconsistency, names),
        *why_outlying(table, order, names),
    )


def _order(table: FitTable) -> IntArray:
    """Return the modes with an accepted fit, in order of frequency."""
    good = table.screening.good
    identified = np.flatnonzero(good.any(axis=1))
    frequency = [float(table.frequency[m][good[m]].mean()) for m in identified]
    return np.asarray(identified[np.argsort(frequency, kind="stable")], np.int64)


def _fitted_modes(table: FitTable, order: IntArray, shapes: ReferenceShapes, n_ref: int) -> FittedModes:
    """Return the fits and shapes of modes for the check of inconsistent frequencies."""
    return FittedModes(
        frequency=table.frequency[order],
        frequency_error=table.frequency_error[order],
        loss_factor=table.loss_factor[order],
        good=table.screening.good[order],
        shape=shapes.shape.repeat(n_ref, axis=1),
        shape_error=shapes.error.repeat(n_ref, axis=1),
        scaled=shapes.scale is not None,
    )


def _averaging(inconsistency: FrequencyInconsistency | None, r: int) -> Averaging:
    """Return the kind of average of frequency and loss factor of a mode."""
    if inconsistency is None:
        return Averaging.WEIGHTED
    if inconsistency.cause is not InconsistencyCause.UNKNOWN:
        return Averaging.PLAIN
    differs = is_significant(float(inconsistency.chi_square[r]), int(inconsistency.degrees[r]))
    return Averaging.SCATTERED if differs else Averaging.WEIGHTED


def _mode(
    table: FitTable,
    m: int,
    averaging: Averaging,
    noise_correlation: float,
    shapes: ReferenceShapes,
    number: int,
    names: Sequence[str],
) -> Mode:
    good = table.screening.good[m]
    mean, damping = _means(table, m, averaging, noise_correlation)
    errors = {"frequency": mean.error, "loss_factor": damping.error}
    bias = leakage_bias_of(table, m)
    return Mode(
        frequency=mean.value,
        loss_factor=damping.value,
        shape=shapes.shape[number],
        frequency_spread=_spread(table.frequency[m][good]),
        loss_factor_spread=_spread(table.loss_factor[m][good]),
        standard_errors=errors,
        shape_errors=shapes.error[number],
        leakage_bias=bias,
        flags=(
            *_unused(table, m, names),
            *shapes.flags(number),
            *leakage_flags(bias, errors, damping.value),
        ),
    )


def _means(table: FitTable, m: int, averaging: Averaging, noise_correlation: float) -> tuple[Mean, Mean]:
    """Return the averages of frequency, Hz, and loss factor of a mode over its accepted fits."""
    good = table.screening.good[m]
    frequency, loss_factor = table.frequency[m][good], table.loss_factor[m][good]
    frequency_error, loss_factor_error = table.frequency_error[m][good], table.loss_factor_error[m][good]
    neglected = INCONSISTENCY.neglected_error * float(loss_factor.mean())
    if averaging is Averaging.WEIGHTED:
        # A fit with a low loss factor also has a low standard error of it: weights from standard errors
        # would bias the mean. Relative errors hardly depend on the fitted loss factor.
        loss_factor_error = loss_factor_error / loss_factor * float(np.median(loss_factor))
    return (
        averaged(
            frequency, frequency_error, neglected * float(frequency.mean()), averaging, noise_correlation
        ),
        averaged(loss_factor, loss_factor_error, neglected, averaging, noise_correlation),
    )


def _spread(values: FloatArray) -> Spread:
    sd = float(values.std(ddof=1)) if len(values) > 1 else 0.0
    return Spread(float(values.min()), float(values.max()), float(values.mean()), sd, len(values))


def _unused(table: FitTable, m: int, names: Sequence[str]) -> list[str]:
    """Return a flag for every FRF that is not part of the means: an outlier, a node, or an imprecise fit."""
    size, error = np.abs(table.modal_constant[m]), table.modal_constant_error[m]
    node = size < np.maximum(NODES.standard_errors * error, NODES.relative_size * size.max())
    flags = []
    for j, name in enumerate(names):
        if table.screening.outlying[m, j]:
            flags.append(f"outlier: {name}")
        elif table.screening.unsure[m, j]:
            flags.append(f"node: {name}" if node[j] else f"unsure: {name}")
    return flags
