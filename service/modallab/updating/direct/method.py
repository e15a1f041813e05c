"""Interface of direct methods: a model's matrices and measured modes give corrections or errors."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from modallab.core.arrays import FloatArray, IntArray, frozen
from modallab.core.dof import Dof
from modallab.core.options import Options, option
from modallab.core.registry import Family, first_line
from modallab.fe.reduction import REDUCTIONS, reduction_of


@dataclass(frozen=True, eq=False)
class Elements:
    """Element matrices of the members of a model; further parts of its matrices belong to no member."""

    numbers: tuple[int, ...]  # of the members
    rows: IntArray  # (n_members, 6) place in the model's matrices, -1 where a DoF is held
    mass: FloatArray  # (n_members, 6, 6) kg
    stiffness: FloatArray  # (n_members, 6, 6) N/m

    def times(self, matrices: FloatArray, shapes: FloatArray) -> FloatArray:
        """Return each member's matrix (n_members, 6, 6) times shapes (n, m), (n_members, n, m)."""
        out = np.zeros((len(self.numbers), len(shapes) + 1, shapes.shape[1]))
        local = np.vstack([shapes, np.zeros(shapes.shape[1])])[self.rows]  # the last row is held: -1
        out[np.arange(len(self.numbers))[:, None], self.rows] = matrices @ local
        return out[:, :-1]

    def sum(self, matrices: FloatArray, n: int) -> FloatArray:
        """Return the (n, n) sum of members' matrices (n_members, 6, 6)."""
        out = np.zeros((n + 1, n + 1))
        np.add.at(out, (self.rows[:, :, None], self.rows[:, None, :]), matrices)
        return out[:-1, :-1]


@dataclass(frozen=True, eq=False)
class DirectProblem:
    """A model's matrices and measured modes at the same degrees of freedom."""

    mass: FloatArray  # (n, n) kg, symmetric
    stiffness: FloatArray  # (n, n) N/m, symmetric
    dofs: tuple[Dof, ...]
    shapes: FloatArray  # (n, m) measured, mass-normalised, 1/sqrt(kg)
    squares: FloatArray  # (m,) omega_r^2 of these, rad^2/s^2
    model_shapes: FloatArray  # (n, k) the model's own, mass-normalised
    model_squares: FloatArray  # (k,) rising
    partners: IntArray  # (m,) which of the model's modes each measured one pairs with
    mac: FloatArray  # (m,) of these pairs
    n_rigid_body: int  # of the model's modes, the first
    elements: Elements | None = None  # None of a reduced model, and of matrices without members

    def __post_init__(self) -> None:
        n, m, k = len(self.dofs), len(self.squares), len(self.model_squares)
        shapes = {
            "mass": (n, n),
            "stiffness": (n, n),
            "shapes": (n, m),
            "squares": (m,),
            "model_shapes": (n, k),
            "model_squares": (k,),
            "mac": (m,),
        }
        for name, shape in shapes.items():
            object.__setattr__(self, name, frozen(getattr(self, name), float, shape, name=name))
        object.__setattr__(self, "partners", frozen(self.partners, int, (m,), name="partners"))


@dataclass(frozen=True, eq=False)
class Correction:
    """Matrices that give a model the measured modes."""

    mass: FloatArray  # (n, n) kg
    stiffness: FloatArray  # (n, n) N/m
    changed: tuple[str, ...] = ("mass", "stiffness")  # those that are not the model's own
    # by part and member, 1 = no change; of methods that keep the members
    coefficients: Mapping[str, Mapping[int, float]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class ErrorLocation:
    """Where a model is wrong, by matrix: `mass`, `stiffness`, or both in one `force_balance`."""

    matrices: Mapping[str, FloatArray]  # (n, n) each
    # (n,) each: size of a DoF's row against what the same modes make of the model's own, 0 where it is right
    dof_errors: Mapping[str, FloatArray]


class DirectMethod(Protocol):
    """Corrects a model's matrices by measured modes, or says where they are wrong, without iteration."""

    def __call__(self, problem: DirectProblem) -> Correction | ErrorLocation:
        """Return updated matrices, or errors by degree of freedom."""
        ...


EXPANSION = "expansion"


@dataclass(frozen=True)
class DirectOptions(Options):
    """Options of every direct method.

    Raises
    ------
    InvalidInputError
        If there is no such completion, or the reduction or its numbers do not exist.
    """

    completion: str = option(
        EXPANSION,
        doc="measured shapes expanded to all DoFs of the model, or the model reduced to measured ones",
        choices=(EXPANSION, *REDUCTIONS),
    )
    expansion: str = option(
        "dynamic", doc="the reduction by which shapes are expanded", choices=tuple(REDUCTIONS)
    )
    n_modes: int | None = option(
        None,
        unit="1",
        lower=1,
        upper=1000,
        doc="number of lowest measured modes that are used; all by default",
    )
    reduction_parameters: Mapping[str, float] = field(default_factory=dict)
    """Numbers of the reduction by name: of `completion`, or else of `expansion`."""

    def __post_init__(self) -> None:
        super().__post_init__()
        reduction_of(self.reduction, self.reduction_parameters)

    @property
    def reduction(self) -> str:
        """The kind of reduction by which either is done."""
        return self.expansion if self.completion == EXPANSION else self.completion


@dataclass(frozen=True)
class RegisteredDirectMethod:
    """A direct method with its options; called, it solves its problem."""

    solve: DirectMethod
    """Updated matrices, or errors by degree of freedom."""
    options: type[DirectOptions] = DirectOptions
    """Options dataclass of the method."""

    @property
    def summary(self) -> str:
        """First line of the method's description."""
        return first_line(self.solve)

    def __call__(self, problem: DirectProblem) -> Correction | ErrorLocation:
        """Return the corrected matrices, or the located errors."""
        return self.solve(problem)


DIRECT_METHODS: Family[RegisteredDirectMethod] = Family(
    "updating method", home="modallab.updating.direct.methods"
)


def relative_row_norms(change: FloatArray, reference: FloatArray, scale: FloatArray) -> FloatArray:
    """Return the size of each row of `change` over that of `reference`, (n,); 0 where both are zero.

    Parameters
    ----------
    change, reference
        (n, k).
    scale
        (k,) factors that give all columns the same unit.
    """
    reference_norms = np.linalg.norm(reference * scale, axis=1)
    # A row that is zero in the reference is compared with the largest row.
    floor = np.finfo(float).eps * float(reference_norms.max(initial=0.0))
    row_norms = np.linalg.norm(change * scale, axis=1)
    return np.asarray(
        np.divide(
            row_norms, np.maximum(reference_norms, floor), out=np.zeros_like(row_norms), where=row_norms > 0
        )
    )


def diagonal_scaling(matrix: FloatArray) -> FloatArray:
    """Return 1 over the root of each diagonal entry, (n,): a scaling that makes a matrix dimensionless."""
    diagonal = np.diag(matrix)
    return np.asarray(
        np.divide(1.0, np.sqrt(np.maximum(diagonal, 0.0)), out=np.zeros(len(diagonal)), where=diagonal > 0)
    )
