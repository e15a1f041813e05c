"""Correlation of measured modes with those of a model."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, frozen
from modallab.core.common_dofs import common_points, rows_at
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfSet
from modallab.core.modal_model import ModalModel
from modallab.core.reply import Matrix, Vector
from modallab.correlation.coordinate import comac, ecomac
from modallab.correlation.mac import mac, pair_modes, pole_weighted_mac
from modallab.correlation.orthogonality import Orthogonality
from modallab.correlation.responses import ResponseCorrelation, compare_responses
from modallab.correlation.settings import PAIRING
from modallab.fe.reduction import ReducedSystem, Reduction, reduce
from modallab.fe.synthetic_modes import exact_modes
from modallab.fe.system import DynamicSystem


@dataclass(frozen=True, eq=False)
class Correlation:
    """Correlation of measured modes with those of a model at their common DoFs."""

    mac: Matrix
    """(n_measured, n_model) modal assurance criterion (MAC), 0 to 1."""
    pairs: tuple[tuple[int, int], ...]
    """Paired modes (measured, model), counted from 1."""
    frequency_differences: Vector
    """Hz, (n_pairs,) measured minus model frequency."""
    comac: Vector
    """(n_common,) coordinate modal assurance criterion (CoMAC) over the pairs, 0 to 1."""
    dofs: tuple[Dof, ...]
    """Common DoFs in their positive sense."""
    ecomac: Vector | None = None
    """(n_common,) enhanced coordinate modal assurance criterion (ECoMAC), 0 agrees."""
    pole_weighted_mac: Matrix | None = None
    """(n_measured, n_model) pole-weighted MAC, 0 to 1."""
    orthogonality: Orthogonality | None = None
    """Orthogonality in the reduced mass matrix, where a reduction was requested."""
    responses: ResponseCorrelation | None = None
    """Correlation of FRFs, where measured FRFs were given."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "mac", frozen(self.mac, float, (None, None), name="mac"))
        pairs, common = (len(self.pairs),), (len(self.dofs),)
        shapes = {"frequency_differences": pairs, "comac": common, "ecomac": common}
        for name, shape in (shapes | {"pole_weighted_mac": self.mac.shape}).items():
            if getattr(self, name) is not None:
                object.__setattr__(self, name, frozen(getattr(self, name), float, shape, name=name))


def correlate(
    system: DynamicSystem,
    measured: ModalModel,
    *,
    count: int | None = None,
    reduction: Reduction | None = None,
    frf: FrfSet | None = None,
) -> Correlation:
    """Return the correlation of a structure with measured modes and, if given, measured FRFs.

    Parameters
    ----------
    count
        Elastic modes of the structure; by default as many as were measured.
    reduction
        To the common DoFs, for orthogonality in the structure's mass.
    frf
        Measured FRFs, compared with the structure's at the same points and lines.

    Raises
    ------
    InvalidInputError
        If the two have no DoF in common, one has no modes, or the common DoFs do not determine the motion
        of the others.
    """
    model = exact_modes(system, count or min(len(measured.modes), PAIRING.max_model_modes))
    masters = common_points(measured.dofs, system.dofs)
    reduced = None
    if reduction is not None and masters:
        highest = max(float(side.frequencies.max(initial=0.0)) for side in (model, measured))
        reduced = reduce(system, masters, reduction.reaching(highest))
    return compare(
        model,
        measured,
        reduced=reduced,
        responses=None if frf is None else compare_responses(frf, system),
    )


def compare(
    model: ModalModel,
    measured: ModalModel,
    *,
    floor: float = PAIRING.min_mac,
    reduced: ReducedSystem | None = None,
    responses: ResponseCorrelation | None = None,
) -> Correlation:
    """Return the correlation of measured modes with those of a model.

    Only the DoFs that both have count; a DoF with sign -1 holds the negative component, and is turned.

    Parameters
    ----------
    floor
        MAC below which modes do not pair.
    reduced, responses
        The model at the common DoFs, in order, for orthogonality; how FRFs agree, to be kept beside it.

    Raises
    ------
    InvalidInputError
        If the two have no DoF in common, or one has no modes.
    """
    dofs, (measured_shapes, model_shapes) = _common(measured, model)
    values = mac(measured_shapes, model_shapes)
    pairs = pair_modes(values, floor)
    rows, columns = [r for r, _ in pairs], [c for _, c in pairs]
    paired = measured_shapes[:, rows], model_shapes[:, columns]
    return Correlation(
        mac=values,
        pairs=tuple((row + 1, column + 1) for row, column in pairs),
        frequency_differences=measured.frequencies[rows] - model.frequencies[columns],
        comac=comac(*paired),
        dofs=dofs,
        ecomac=ecomac(*paired),
        pole_weighted_mac=pole_weighted_mac(
            measured_shapes, model_shapes, _eigenvalues(measured), _eigenvalues(model)
        ),
        orthogonality=None
        if reduced is None
        else Orthogonality.of(reduced, measured_shapes, model_shapes, model),
        responses=responses,
    )


def _eigenvalues(side: ModalModel) -> ComplexArray:
    return np.array([mode.eigenvalue for mode in side.modes])


def _common(
    measured: ModalModel, model: ModalModel
) -> tuple[tuple[Dof, ...], tuple[ComplexArray, ComplexArray]]:
    """Return the common DoFs and the shapes there, (n_common, n_modes) each, in the positive sense."""
    sides = (measured, model)
    if not all(side.modes for side in sides):
        raise InvalidInputError("there are no modes to compare", field="modes", value=0, allowed=bounds(1))
    dofs = common_points(measured.dofs, model.dofs)
    if not dofs:
        raise InvalidInputError(
            "the two sets of modes share no degree of freedom",
            field="dofs",
            value=[str(dof) for dof in measured.dofs[:5]],
            allowed=[str(dof) for dof in model.dofs[:5]],
        )
    picked = ((side.shapes, *rows_at(side.dofs, dofs)) for side in sides)
    measured_shapes, model_shapes = (shapes[rows] * signs[:, None] for shapes, rows, signs in picked)
    return dofs, (measured_shapes, model_shapes)
