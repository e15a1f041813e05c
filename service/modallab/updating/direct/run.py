"""Run a direct method, and judge what it did."""

import numpy as np
from scipy.linalg import eigvalsh
from scipy.optimize import linear_sum_assignment

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress, silent
from modallab.correlation.mac import mac
from modallab.fe.reduction import pencil_modes
from modallab.fe.system import DynamicSystem
from modallab.updating.direct.completion import Completed, complete
from modallab.updating.direct.method import (
    DIRECT_METHODS,
    Correction,
    DirectOptions,
    DirectProblem,
    ErrorLocation,
    of_one_unit,
    row_shares,
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
    """Return what a direct method makes of a structure and measured modes.

    Parameters
    ----------
    method
        One of `DIRECT_METHODS`.
    target
        Measured modes; with `n_modes` the lowest are used, and the others show how far the result holds.

    Raises
    ------
    InvalidInputError, UnknownDofError, UnderdeterminedError
        If method and options do not fit, or measurement and structure do not.
    """
    find = DIRECT_METHODS[method]
    progress(0.1, "model and shapes are brought to the same degrees of freedom")
    ready = complete(system, target, options)
    count = _used(options, len(ready.squares))
    problem = ready.problem(count)
    progress(0.4, f"{method} with {count} modes")
    found = find(problem)
    progress(0.7, "modes of the result are compared")
    if isinstance(found, ErrorLocation):
        return _located(method, ready, problem, found)
    return _corrected(method, ready, problem, found)


def _used(options: DirectOptions, n_measured: int) -> int:
    count = n_measured if options.n_modes is None else options.n_modes
    if not 1 <= count <= n_measured:
        raise InvalidInputError(
            "as many modes are not there to be used",
            field="n_modes",
            value=count,
            allowed=f"1 to {n_measured}",
        )
    return count


def _located(method: str, ready: Completed, problem: DirectProblem, found: ErrorLocation) -> DirectResult:
    before, mac_before = _beside(ready, problem.mass, problem.model_squares, problem.model_shapes)
    return DirectResult(
        method=method,
        dofs=ready.dofs,
        completion=ready.how,
        mass=None,
        stiffness=None,
        errors=found.matrices,
        dof_errors=found.dof_errors,
        connectivity_loss={},
        modes=MeasuredModes(
            len(problem.squares), _hertz(ready.squares), before, mac_before, after=None, mac_after=None
        ),
        others=None,
        reproduced=None,
        notes=ready.notes,
    )


def _corrected(method: str, ready: Completed, problem: DirectProblem, found: Correction) -> DirectResult:
    own = {"mass": problem.mass, "stiffness": problem.stiffness}
    errors = {name: getattr(found, name) - own[name] for name in found.changed}
    squares, shapes = pencil_modes(found.mass, found.stiffness)
    before, mac_before = _beside(ready, problem.mass, problem.model_squares, problem.model_shapes)
    after, mac_after = _beside(ready, found.mass, squares, shapes)
    n = len(problem.squares)
    modes = MeasuredModes(n, _hertz(ready.squares), before, mac_before, after, mac_after)
    off = np.abs(after / modes.measured - 1)[:n].max()
    return DirectResult(
        method=method,
        dofs=ready.dofs,
        completion=ready.how,
        mass=found.mass,
        stiffness=found.stiffness,
        errors=errors,
        dof_errors={
            name: row_shares(error, own[name], of_one_unit(own[name])) for name, error in errors.items()
        },
        connectivity_loss=_lost(ready, own, errors),
        modes=modes,
        others=_others(problem, found, squares, shapes),
        reproduced=float(max(off, 1 - mac_after[:n].min())),
        notes=ready.notes,
        coefficients=found.coefficients,
    )


def _lost(ready: Completed, own: dict[str, FloatArray], errors: dict[str, FloatArray]) -> dict[str, float]:
    """Return by matrix the norm of a correction outside the structure's connections over its whole norm.

    Each entry counts in units of its DoFs, sqrt(A_ii A_jj). Of a reduced model nothing is said: it has no
    connections of the structure left.
    """
    if ready.pattern is None:
        return {}
    lost = {}
    for name, error in errors.items():
        scale = of_one_unit(own[name])
        even = scale[:, None] * error * scale
        whole = float(np.linalg.norm(even))
        lost[name] = float(np.linalg.norm(even[~ready.pattern])) / whole if whole else 0.0
    return lost


def _beside(
    ready: Completed, mass: FloatArray, squares: FloatArray, shapes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return frequency, Hz, and MAC of the mode nearest to each measured one, (n_measured,) each.

    Nearest in the mass, where modes are orthonormal: a MAC lets stiff DoFs that hardly move decide.
    """
    likeness = (ready.shapes.T @ mass @ shapes) ** 2
    chosen = _assigned(likeness)
    table = mac(ready.shapes, shapes[:, chosen])
    return _hertz(squares[chosen]), np.diag(table)


def _others(problem: DirectProblem, found: Correction, squares: FloatArray, shapes: FloatArray) -> OtherModes:
    """Return the model's modes that no measured one pairs with, beside what became of them.

    Rigid-body motions are held against the corrected matrices as a whole: which of them is first is chance.
    """
    n_rigid_body = problem.n_rigid_body
    kept = np.setdiff1d(np.arange(n_rigid_body, len(problem.model_squares)), problem.partners)
    likeness = (problem.model_shapes.T @ problem.mass @ shapes) ** 2
    partner = _assigned(likeness)[kept]
    alike = mac(problem.model_shapes[:, kept], shapes[:, partner])
    held = None
    if n_rigid_body:
        bodies = problem.model_shapes[:, :n_rigid_body]
        stiffness, mass = (bodies.T @ matrix @ bodies for matrix in (found.stiffness, found.mass))
        held = float(_hertz(eigvalsh(stiffness, mass)[-1:])[0])
    return OtherModes(_hertz(problem.model_squares[kept]), _hertz(squares[partner]), np.diag(alike), held)


def _assigned(likeness: FloatArray) -> IntArray:
    """Return the column of each row, each used once while they last, so that likeness adds up to most."""
    rows, columns = linear_sum_assignment(likeness, maximize=True)
    chosen = likeness.argmax(axis=1)
    chosen[rows] = columns
    return np.asarray(chosen)


def _hertz(squares: FloatArray) -> FloatArray:
    return np.asarray(np.sign(squares) * np.sqrt(np.abs(squares)) / (2 * np.pi))
