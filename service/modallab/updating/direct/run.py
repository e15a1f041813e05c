"""Direct updating: completion of the shapes, solution and comparison of modes."""

import numpy as np
import scipy
from scipy.linalg import eigvalsh

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, silent
from modallab.correlation.mac import mac
from modallab.fe.reduction import pencil_modes
from modallab.fe.system import DynamicSystem
from modallab.updating.direct.completion import CompletedModel, complete
from modallab.updating.direct.method import (
    DIRECT_METHODS,
    Correction,
    DirectOptions,
    DirectProblem,
    ErrorLocation,
    diagonal_scaling,
    relative_row_norms,
)
from modallab.updating.direct.result import DirectResult, MeasuredModes, OtherModes

DEFAULTS = DirectOptions()


def update_directly(
    system: DynamicSystem,
    method: str,
    target: ModalModel,
    *,
    options: DirectOptions = DEFAULTS,
    progress: Progress = silent,
) -> DirectResult:
    """Return the result of a direct method for a structure and measured modes.

    Parameters
    ----------
    method
        One of `DIRECT_METHODS`.
    target
        Measured modes; with `n_modes` the lowest are used, and the others validate the result.

    Raises
    ------
    InvalidInputError, UnknownDofError, UnderdeterminedError
        If method and options do not fit, or measurement and structure do not.
    """
    solve = DIRECT_METHODS[method]
    progress(0.1, "model and shapes are brought to the same degrees of freedom")
    completed = complete(system, target, options)
    count = _n_used_modes(options, len(completed.squares))
    problem = completed.problem(count)
    progress(0.4, f"{method} with {count} modes")
    solution = solve(problem)
    progress(0.7, "modes of the result are compared")
    if isinstance(solution, ErrorLocation):
        return _location_result(method, completed, problem, solution)
    return _correction_result(method, completed, problem, solution)


def _n_used_modes(options: DirectOptions, n_measured: int) -> int:
    count = n_measured if options.n_modes is None else options.n_modes
    if not 1 <= count <= n_measured:
        raise InvalidInputError(
            "as many modes are not there to be used",
            field="n_modes",
            value=count,
            allowed=bounds(1, n_measured),
        )
    return count


def _location_result(
    method: str, completed: CompletedModel, problem: DirectProblem, location: ErrorLocation
) -> DirectResult:
    model_frequencies, model_mac = _nearest_modes(
        completed, problem.mass, problem.model_squares, problem.model_shapes
    )
    return DirectResult(
        method=method,
        dofs=completed.dofs,
        completion=completed.description,
        mass=None,
        stiffness=None,
        errors=location.matrices,
        dof_errors=location.dof_errors,
        connectivity_loss={},
        modes=MeasuredModes(
            len(problem.squares),
            _hertz(completed.squares),
            model_frequencies,
            model_mac,
            after=None,
            mac_after=None,
        ),
        other_modes=None,
        reproduced=None,
        notes=completed.notes,
    )


def _correction_result(
    method: str, completed: CompletedModel, problem: DirectProblem, correction: Correction
) -> DirectResult:
    model_matrices = {"mass": problem.mass, "stiffness": problem.stiffness}
    errors = {name: getattr(correction, name) - model_matrices[name] for name in correction.changed}
    squares, shapes = pencil_modes(correction.mass, correction.stiffness)
    model_frequencies, model_mac = _nearest_modes(
        completed, problem.mass, problem.model_squares, problem.model_shapes
    )
    updated_frequencies, updated_mac = _nearest_modes(completed, correction.mass, squares, shapes)
    n = len(problem.squares)
    modes = MeasuredModes(
        n, _hertz(completed.squares), model_frequencies, model_mac, updated_frequencies, updated_mac
    )
    frequency_error = np.abs(updated_frequencies / modes.measured - 1)[:n].max()
    return DirectResult(
        method=method,
        dofs=completed.dofs,
        completion=completed.description,
        mass=correction.mass,
        stiffness=correction.stiffness,
        errors=errors,
        dof_errors={
            name: relative_row_norms(error, model_matrices[name], diagonal_scaling(model_matrices[name]))
            for name, error in errors.items()
        },
        connectivity_loss=_connectivity_loss(completed, model_matrices, errors),
        modes=modes,
        other_modes=_other_modes(problem, correction, squares, shapes),
        reproduced=float(max(frequency_error, 1 - updated_mac[:n].min())),
        notes=completed.notes,
        coefficients=correction.coefficients,
    )


def _connectivity_loss(
    completed: CompletedModel, model_matrices: dict[str, FloatArray], errors: dict[str, FloatArray]
) -> dict[str, float]:
    """Return by matrix the norm of a correction between unconnected DoFs over its whole norm.

    Entries are scaled by the DoFs, sqrt(A_ii A_jj). A reduced model has no connections of the structure, and
    no result.
    """
    if completed.pattern is None:
        return {}
    losses = {}
    for name, error in errors.items():
        scale = diagonal_scaling(model_matrices[name])
        scaled_error = scale[:, None] * error * scale
        total_norm = float(np.linalg.norm(scaled_error))
        losses[name] = (
            float(np.linalg.norm(scaled_error[~completed.pattern])) / total_norm if total_norm else 0.0
        )
    return losses


def _nearest_modes(
    completed: CompletedModel, mass: FloatArray, squares: FloatArray, shapes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return frequency, Hz, and MAC of the mode nearest to each measured one, (n_measured,) each.

    Nearest by mass-weighted products, in which modes are orthonormal: in a MAC stiff DoFs that hardly move
    would decide.
    """
    overlap = (completed.shapes.T @ mass @ shapes) ** 2
    columns = _assignment(overlap)
    table = mac(completed.shapes, shapes[:, columns])
    return _hertz(squares[columns]), np.diag(table)


def _other_modes(
    problem: DirectProblem, correction: Correction, squares: FloatArray, shapes: FloatArray
) -> OtherModes:
    """Return the model's modes without a measured partner, beside their corrected counterparts.

    Rigid-body motions are compared as one subspace: their order is arbitrary.
    """
    n_rigid_body = problem.n_rigid_body
    unpaired = np.setdiff1d(np.arange(n_rigid_body, len(problem.model_squares)), problem.partners)
    overlap = (problem.model_shapes.T @ problem.mass @ shapes) ** 2
    partner = _assignment(overlap)[unpaired]
    mac_table = mac(problem.model_shapes[:, unpaired], shapes[:, partner])
    rigid_body_frequency = None
    if n_rigid_body:
        rigid_shapes = problem.model_shapes[:, :n_rigid_body]
        stiffness, mass = (
            rigid_shapes.T @ matrix @ rigid_shapes for matrix in (correction.stiffness, correction.mass)
        )
        rigid_body_frequency = float(_hertz(eigvalsh(stiffness, mass)[-1:])[0])
    return OtherModes(
        _hertz(problem.model_squares[unpaired]),
        _hertz(squares[partner]),
        np.diag(mac_table),
        rigid_body_frequency,
    )


def _assignment(overlap: FloatArray) -> IntArray:
    """Return the column of each row with the largest total overlap, each used once as far as possible."""
    rows, columns = scipy.optimize.linear_sum_assignment(overlap, maximize=True)
    columns_of_rows = overlap.argmax(axis=1)
    columns_of_rows[rows] = columns
    return np.asarray(columns_of_rows)


def _hertz(squares: FloatArray) -> FloatArray:
    return np.asarray(np.sign(squares) * np.sqrt(np.abs(squares)) / (2 * np.pi))
