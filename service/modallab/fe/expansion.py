"""Measured shapes at all degrees of freedom of a model."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, frozen
from modallab.core.common_dofs import common_points, rows_at
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel
from modallab.fe.reduction import ReducedSystem, Reduction, reduce
from modallab.fe.system import DynamicSystem


@dataclass(frozen=True, eq=False)
class Expansion:
    """Modes at all DoFs of a model, and how far the model goes along with what was measured."""

    model: ModalModel
    residual: FloatArray  # (n_modes,) part of the measured shape that the expanded one does not have
    rayleigh: FloatArray  # (n_modes,) Hz, at which the model's strain and kinetic energy in the shape balance

    def __post_init__(self) -> None:
        n = (len(self.model.modes),)
        for name in ("residual", "rayleigh"):
            object.__setattr__(self, name, frozen(getattr(self, name), float, n, name=name))


def expand(system: DynamicSystem, measured: ModalModel, reduction: Reduction) -> Expansion:
    """Return measured modes at all DoFs of a model: phi = T phi_measured, T of `reduction`.

    Scale and phase stay as measured. Measured DoFs that the model lacks are left out. `residual` is
    |phi_m - (T phi_m)_m| / |phi_m|: 0 where a reduction lets masters follow themselves, with SEREP what no
    mode of the model has. `rayleigh` far from the measured frequency means that the model would not
    move like this. Standard errors of the shapes follow as those of independent numbers.

    Raises
    ------
    InvalidInputError
        If model and measurement share no DoF, or these do not determine the motion of all the others.
    """
    masters = common_points(measured.dofs, system.dofs)
    if not masters or not measured.modes:
        raise InvalidInputError(
            "nothing was measured at a degree of freedom of the model",
            field="dofs",
            value=", ".join(str(dof) for dof in measured.dofs[:5]),
            allowed=", ".join(str(dof) for dof in system.dofs[:5]),
        )
    rows, signs = rows_at(measured.dofs, masters)
    own = [reduction.at_mode(mode.frequency) for mode in measured.modes]
    known = {one: reduce(system, masters, one) for one in dict.fromkeys(own)}
    seen = signs[:, None] * measured.shapes[rows]
    # `systems` of one reduction for all modes are one and the same
    systems = [known[one] for one in own]
    shapes = np.stack([s.transformation @ x for s, x in zip(systems, seen.T, strict=True)], axis=1)
    residual = _residual(shapes[[system.index(dof) for dof in masters]], seen)
    modes = []
    for r, (mode, reduced) in enumerate(zip(measured.modes, systems, strict=True)):
        errors = None
        if mode.shape_errors is not None:
            errors = np.sqrt(reduced.transformation**2 @ mode.shape_errors[rows] ** 2)
        modes.append(replace(mode, shape=shapes[:, r], shape_errors=errors))
    left_out = len(measured.dofs) - len(rows)
    notes = (f"{left_out} measured degrees of freedom are none of the model's",) if left_out else ()
    model = ModalModel(
        modes=tuple(modes),
        dofs=system.dofs,
        normalisation=measured.normalisation,
        method=measured.method,
        notes=(*measured.notes, *notes),
    )
    return Expansion(model, residual, _rayleigh(systems, seen))


def _residual(expanded: ComplexArray, seen: ComplexArray) -> FloatArray:
    size = np.linalg.norm(seen, axis=0)
    misfit = np.linalg.norm(seen - expanded, axis=0)
    return np.asarray(np.divide(misfit, size, out=np.zeros_like(size), where=size > 0))


def _rayleigh(systems: list[ReducedSystem], seen: ComplexArray) -> FloatArray:
    """Return sqrt(phi^H K phi / phi^H M phi) / 2 pi of each expanded shape, (n_modes,), Hz."""
    strain = np.array([(x.conj() @ s.stiffness @ x).real for s, x in zip(systems, seen.T, strict=True)])
    moving = np.array([(x.conj() @ s.mass @ x).real for s, x in zip(systems, seen.T, strict=True)])
    square = np.divide(strain, moving, out=np.zeros_like(strain), where=moving > 0)
    return np.asarray(np.sqrt(np.maximum(square, 0.0)) / (2 * np.pi))
