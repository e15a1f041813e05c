"""Expansion of measured mode shapes to all degrees of freedom of a model."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray, frozen
from modallab.core.common_dofs import common_points, rows_at
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel, Mode
from modallab.fe.reduction import ReducedSystem, Reduction, reduce
from modallab.fe.settings import REDUCTION
from modallab.fe.system import DynamicSystem

FLAG = "doubtful_expansion"


@dataclass(frozen=True, eq=False)
class Expansion:
    """Modes expanded to all DoFs of a model, with measures of their agreement with the model."""

    model: ModalModel
    residual: FloatArray  # (n_modes,) norm of measured minus expanded shape over the measured norm
    rayleigh: FloatArray  # (n_modes,) Hz, from the Rayleigh quotient of the expanded shape

    def __post_init__(self) -> None:
        n = (len(self.model.modes),)
        for name in ("residual", "rayleigh"):
            object.__setattr__(self, name, frozen(getattr(self, name), float, n, name=name))


def expand(system: DynamicSystem, measured: ModalModel, reduction: Reduction) -> Expansion:
    """Return measured modes at all DoFs of a model: phi = T phi_measured, T of `reduction`.

    Scale and phase stay as measured. Measured DoFs that are not in the model are left out. `residual` is
    |phi_m - (T phi_m)_m| / |phi_m|: 0 for a reduction in which masters follow themselves, with SEREP the part
    outside the space of the model's modes. A `rayleigh` far from the measured frequency means that the shape
    is no mode of the model. Modes with a residual or a relative frequency difference above
    `REDUCTION.doubtful_expansion` are flagged. Standard errors of the shapes are propagated as those of
    independent values.

    Raises
    ------
    InvalidInputError
        If model and measurement share no DoF, or these do not determine the motion of all the others.
    """
    masters = _masters(system, measured)
    rows, signs = rows_at(measured.dofs, masters)
    suited = reduction.reaching(float(measured.frequencies.max()))
    per_mode = [suited.at_mode(mode.frequency) for mode in measured.modes]
    # one reduction for all modes, unless it depends on the mode's frequency
    reduced_by = {
        mode_reduction: reduce(system, masters, mode_reduction) for mode_reduction in dict.fromkeys(per_mode)
    }
    systems = [reduced_by[mode_reduction] for mode_reduction in per_mode]
    measured_shapes = signs[:, None] * measured.shapes[rows]
    shapes = np.stack([s.transformation @ x for s, x in zip(systems, measured_shapes.T, strict=True)], axis=1)
    residual = _residual(shapes[[system.index(dof) for dof in masters]], measured_shapes)
    rayleigh = _rayleigh(systems, measured_shapes)
    shifted = np.abs(rayleigh - measured.frequencies) > REDUCTION.doubtful_expansion * measured.frequencies
    doubtful = shifted | (residual > REDUCTION.doubtful_expansion)
    modes = [
        _expanded_mode(mode, shapes[:, r], rows, systems[r], doubtful=bool(doubtful[r]))
        for r, mode in enumerate(measured.modes)
    ]
    left_out = len(measured.dofs) - len(rows)
    notes = (f"{left_out} measured degrees of freedom are none of the model's",) if left_out else ()
    model = ModalModel(
        modes=tuple(modes),
        dofs=system.dofs,
        normalisation=measured.normalisation,
        method=measured.method,
        choices={**measured.choices, "expansion": _choice(reduction, systems[0], residual)},
        notes=(*measured.notes, *notes),
    )
    return Expansion(model, residual, rayleigh)


def _masters(system: DynamicSystem, measured: ModalModel) -> tuple[Dof, ...]:
    """Return the DoFs that were measured and that the model has."""
    masters = common_points(measured.dofs, system.dofs)
    if not masters or not measured.modes:
        raise InvalidInputError(
            "nothing was measured at a degree of freedom of the model",
            field="dofs",
            value=[str(dof) for dof in measured.dofs[:5]],
            allowed=[str(dof) for dof in system.dofs[:5]],
        )
    return masters


def _expanded_mode(
    mode: Mode, shape: ComplexArray, rows: IntArray, by: ReducedSystem, *, doubtful: bool
) -> Mode:
    """Return a mode with its shape and standard errors at all DoFs."""
    errors = mode.shape_errors
    if errors is not None:
        errors = np.sqrt(by.transformation**2 @ errors[rows] ** 2)
    flags = (*mode.flags, FLAG) if doubtful else mode.flags
    return replace(mode, shape=shape, shape_errors=errors, flags=flags)


def _choice(reduction: Reduction, reduced: ReducedSystem, residual: FloatArray) -> str:
    numbers = ", ".join(f"{name} {value:g}" for name, value in reduction.parameters.items() if value)
    description = f"{reduction.kind} ({numbers})" if numbers else reduction.kind
    n_motions = len(reduced.modes()[0])
    from_to = f"{n_motions} motions from {len(reduced.masters)} degrees of freedom"
    return f"{description}, {from_to}: leaves up to {residual.max():.2g} of a measured shape"


def _residual(expanded: ComplexArray, measured: ComplexArray) -> FloatArray:
    size = np.linalg.norm(measured, axis=0)
    misfit = np.linalg.norm(measured - expanded, axis=0)
    return np.asarray(np.divide(misfit, size, out=np.zeros_like(size), where=size > 0))


def _rayleigh(systems: list[ReducedSystem], measured: ComplexArray) -> FloatArray:
    """Return sqrt(phi^H K phi / phi^H M phi) / 2 pi of each expanded shape, (n_modes,), Hz."""
    strain = np.array([(x.conj() @ s.stiffness @ x).real for s, x in zip(systems, measured.T, strict=True)])
    kinetic = np.array([(x.conj() @ s.mass @ x).real for s, x in zip(systems, measured.T, strict=True)])
    square = np.divide(strain, kinetic, out=np.zeros_like(strain), where=kinetic > 0)
    return np.asarray(np.sqrt(np.maximum(square, 0.0)) / (2 * np.pi))
