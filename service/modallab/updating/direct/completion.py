"""Completion of modes: model and measured modes at the same degrees of freedom."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnderdeterminedError, bounds, in_words
from modallab.core.modal_model import ModalModel
from modallab.correlation.mac import mac, pair_modes
from modallab.fe.expansion import FLAG, expand
from modallab.fe.reduction import REDUCTIONS, pencil_modes, reduce, reduction_of
from modallab.fe.system import DynamicSystem
from modallab.updating.direct.method import EXPANSION, DirectOptions, DirectProblem, Elements
from modallab.updating.direct.settings import DIRECT_UPDATING
from modallab.updating.target import real_modes


@dataclass(frozen=True, eq=False)
class CompletedModel:
    """Matrices of a model, and all measured modes at their degrees of freedom."""

    mass: FloatArray  # (n, n) kg
    stiffness: FloatArray  # (n, n) N/m
    pattern: BoolArray | None  # (n, n) True between connected DoFs; None for a reduced model
    dofs: tuple[Dof, ...]
    shapes: FloatArray  # (n, n_measured) mass-normalised, 1/sqrt(kg)
    squares: FloatArray  # (n_measured,) rad^2/s^2
    description: str  # of the completion, for readers
    notes: tuple[str, ...]
    elements: Elements | None = None

    def problem(self, n_modes: int) -> DirectProblem:
        """Return the problem for a method: the lowest `n_modes` measured modes, paired with the model's.

        Raises
        ------
        UnderdeterminedError
            If the model has fewer elastic modes than `n_modes`.
        """
        model_squares, model_shapes = pencil_modes(self.mass, self.stiffness)
        squares, shapes = self.squares[:n_modes], self.shapes[:, :n_modes]
        n_rigid_body = int((model_squares <= DIRECT_UPDATING.rigid_body_ratio * squares.min()).sum())
        candidates = np.arange(n_rigid_body, len(model_squares))
        table = mac(shapes, model_shapes[:, candidates])
        partner = dict(pair_modes(table, 0.0))
        if len(partner) < n_modes:
            raise UnderdeterminedError(
                f"{n_modes} measured modes, and {len(candidates)} of the model at these degrees of freedom",
                field="n_modes",
                value=n_modes,
                allowed=bounds(maximum=len(partner)),
            )
        columns = np.array([partner[r] for r in range(n_modes)])
        return DirectProblem(
            mass=self.mass,
            stiffness=self.stiffness,
            dofs=self.dofs,
            shapes=shapes,
            squares=squares,
            model_shapes=model_shapes,
            model_squares=model_squares,
            partners=candidates[columns],
            mac=table[np.arange(n_modes), columns],
            n_rigid_body=n_rigid_body,
            elements=self.elements,
        )


def complete(system: DynamicSystem, target: ModalModel, options: DirectOptions) -> CompletedModel:
    """Return model and measured modes at the same DoFs: shapes expanded to the model's, or the model reduced.

    Where every DoF was measured, neither is done. Shapes without a scale are normalised by the model's mass.

    Raises
    ------
    UnknownDofError
        If the structure lacks a measured DoF.
    InvalidInputError
        If a mode is complex, a DoF was measured twice, the reduction does not exist for these DoFs, or the
        matrices are too large.
    """
    measured = _in_model_order(system, target)
    if len(measured.dofs) == len(system.dofs):
        completed = _as_measured(system, measured)
    elif options.completion == EXPANSION:
        completed = _expanded(system, measured, options)
    else:
        completed = _reduced(system, measured, options)
    if completed.pattern is not None:
        completed = replace(completed, elements=_elements(system))
    if target.normalisation == "mass":
        return completed
    sizes = np.sqrt(np.einsum("ir,ij,jr->r", completed.shapes, completed.mass, completed.shapes))
    note = "measured shapes had no scale: they were given that of the model's mass"
    return replace(completed, shapes=completed.shapes / sizes, notes=(*completed.notes, note))


def _elements(system: DynamicSystem) -> Elements | None:
    table = system.members
    if table is None:
        return None
    return Elements(table.numbers, table.rows, table.mass, table.axial + table.bending)


def _in_model_order(system: DynamicSystem, target: ModalModel) -> ModalModel:
    """Return measured modes as real ones, at positive DoFs in the order of the model.

    Raises
    ------
    UnknownDofError, InvalidInputError
        As `complete`.
    """
    modes = real_modes(target)
    rows = np.array([system.index(dof) for dof in target.dofs])
    if len(set(rows.tolist())) < len(rows):
        duplicate = next(dof for i, dof in enumerate(target.dofs) if rows[i] in rows[:i])
        raise InvalidInputError(
            f"{duplicate} was measured twice", field="dofs", value=str(duplicate), allowed="each DoF once"
        )
    order, by_frequency = np.argsort(rows), np.argsort(target.frequencies, kind="stable")
    signs = np.array([dof.sign for dof in target.dofs])[:, None]
    shapes = (signs * modes.shapes)[order]
    return replace(
        target,
        modes=tuple(replace(target.modes[r], shape=shapes[:, r], shape_errors=None) for r in by_frequency),
        dofs=tuple(system.dofs[rows[i]] for i in order),
    )


def _full_matrices(system: DynamicSystem) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return mass, stiffness and connectivity as full matrices (n, n), with all attachments."""
    folded, n = system.folded(), len(system.dofs)
    if folded.mass.shape[0] > n:
        raise InvalidInputError(
            "what is attached to the structure has degrees of freedom that no shape is known at",
            field="completion",
            value=EXPANSION,
            allowed=list(REDUCTIONS),
        )
    if n > DIRECT_UPDATING.max_dofs:
        raise InvalidInputError(
            "too many degrees of freedom for full matrices; reduce the model to measured ones by "
            f"{in_words(list(REDUCTIONS))}",
            field="completion",
            value=n,
            allowed=bounds(maximum=DIRECT_UPDATING.max_dofs),
        )
    pattern = np.zeros((n, n), bool)
    for matrix in (folded.mass, folded.stiffness):
        entries = matrix.tocoo()
        pattern[entries.row, entries.col] = True
    return folded.mass.toarray(), folded.stiffness.toarray(), pattern


def _as_measured(system: DynamicSystem, measured: ModalModel) -> CompletedModel:
    squares = (2 * np.pi * measured.frequencies) ** 2
    how = "every degree of freedom was measured"
    return CompletedModel(*_full_matrices(system), system.dofs, measured.shapes.real, squares, how, ())


def _expanded(system: DynamicSystem, measured: ModalModel, options: DirectOptions) -> CompletedModel:
    matrices = _full_matrices(system)
    expansion = expand(system, measured, reduction_of(options.reduction, options.reduction_parameters))
    doubtful = [str(r) for r, mode in enumerate(expansion.model.modes, 1) if FLAG in mode.flags]
    note = f"the model would not move as expanded in modes {', '.join(doubtful)}"
    squares = (2 * np.pi * measured.frequencies) ** 2
    return CompletedModel(
        *matrices,
        system.dofs,
        expansion.model.shapes.real,
        squares,
        f"expanded: {expansion.model.choices[EXPANSION]}",
        (note,) if doubtful else (),
    )


def _reduced(system: DynamicSystem, measured: ModalModel, options: DirectOptions) -> CompletedModel:
    highest = float(measured.frequencies.max())
    reduction = reduction_of(options.reduction, options.reduction_parameters).reaching(highest)
    # A dynamic reduction without a stated frequency takes the median of the modes.
    small = reduce(system, measured.dofs, reduction.at_mode(float(np.median(measured.frequencies))))
    squares = (2 * np.pi * measured.frequencies) ** 2
    numbers = ", ".join(f"{name} {value:g}" for name, value in small.reduction.parameters.items() if value)
    how = f"reduced to {len(measured.dofs)} degrees of freedom: {small.reduction.kind}"
    return CompletedModel(
        small.mass,
        small.stiffness,
        None,
        measured.dofs,
        measured.shapes.real,
        squares,
        f"{how} ({numbers})" if numbers else how,
        (),
    )
