"""Result of a direct updating method, and its accuracy."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from modallab.core.arrays import FloatArray, frozen
from modallab.core.dof import Dof
from modallab.core.reply import Vector
from modallab.updating.direct.settings import DIRECT_UPDATING
from modallab.updating.iteration import StopReason


@dataclass(frozen=True, eq=False)
class MeasuredModes:
    """Measured modes beside the nearest modes of the model, before and after; the used ones first."""

    n_used: int
    """Measured modes that the method used."""
    measured: FloatArray
    """Hz, measured natural frequencies (n_measured,)."""
    before: FloatArray
    """Hz, natural frequencies of the model (n_measured,)."""
    mac_before: FloatArray
    """Modal assurance criterion before (n_measured,)."""
    after: FloatArray | None
    """Hz, natural frequencies after (n_measured,); None without a correction."""
    mac_after: FloatArray | None
    """Modal assurance criterion after (n_measured,); None without a correction."""

    def __post_init__(self) -> None:
        for name in ("measured", "before", "mac_before", "after", "mac_after"):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, frozen(value, float, (len(self.measured),), name=name))

    @property
    def frequencies(self) -> dict[str, FloatArray]:
        """Hz, natural frequencies (n_measured,) by name: measured, before and, of a correction, after."""
        values = {"measured": self.measured, "before": self.before}
        return values if self.after is None else values | {"after": self.after}

    @property
    def mac(self) -> dict[str, FloatArray]:
        """Modal assurance criterion (n_measured,) by name: before and, of a correction, after."""
        values = {"before": self.mac_before}
        return values if self.mac_after is None else values | {"after": self.mac_after}


@dataclass(frozen=True)
class DofError:
    """Error of a matrix at a degree of freedom."""

    dof: Dof
    """Degree of freedom."""
    error: float
    """1, relative error of the matrix there."""


@dataclass(frozen=True, eq=False)
class OtherModes:
    """Elastic modes of the model without a used measured mode, before and after the correction.

    Negative frequencies stand for negative stiffness: -sqrt(-omega^2) / 2 pi.
    """

    before: Vector
    """Hz, natural frequencies of the model in rising order (k,)."""
    after: Vector
    """Hz, natural frequencies after (k,)."""
    mac: Vector
    """Modal assurance criterion of each pair (k,)."""
    rigid_body: float | None
    """Hz, highest frequency that the corrected matrices give a former rigid-body motion; None without one."""

    def __post_init__(self) -> None:
        for name in ("before", "after", "mac"):
            object.__setattr__(self, name, frozen(getattr(self, name), float, (len(self.before),), name=name))


@dataclass(frozen=True, eq=False)
class DirectResult:
    """Result of a direct method, at the degrees of freedom it worked at."""

    method: str
    """Name of the method."""
    dofs: tuple[Dof, ...]
    """(n,) degrees of freedom of the matrices."""
    completion: str
    """How model and shapes came to the same degrees of freedom, for readers."""
    mass: FloatArray | None
    """kg, updated mass matrix (n, n); None where the method only locates errors."""
    stiffness: FloatArray | None
    """N/m, updated stiffness matrix (n, n); None where the method only locates errors."""
    errors: Mapping[str, FloatArray]
    """By matrix: correction, or estimated error (n, n)."""
    dof_errors: Mapping[str, FloatArray]
    """By matrix: relative error of each degree of freedom (n,)."""
    connectivity_loss: Mapping[str, float]
    """By matrix: norm of the correction between unconnected DoFs over its whole norm."""
    modes: MeasuredModes
    """Measured modes beside those of the model."""
    other_modes: OtherModes | None
    """Modes of the model without a used measured mode; None without a correction."""
    reproduced: float | None
    """Largest relative error of a used frequency, or of 1 - MAC; None without a correction."""
    notes: tuple[str, ...] = field(default=())
    """Remarks for readers."""
    coefficients: Mapping[str, Mapping[int, float]] = field(default_factory=dict)
    """By part and member, 1 = no change; of methods that keep the members."""

    def __post_init__(self) -> None:
        n = len(self.dofs)
        for name in ("mass", "stiffness"):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, frozen(value, float, (n, n), name=name))
        for name, shape in (("errors", (n, n)), ("dof_errors", (n,))):
            tables = {
                key: frozen(table, float, shape, name=name) for key, table in getattr(self, name).items()
            }
            object.__setattr__(self, name, tables)

    @property
    def converged(self) -> bool:
        """True if there is an updated model with the measured modes."""
        return self.reproduced is not None and self.reproduced < DIRECT_UPDATING.reproduction_error

    @property
    def corrects(self) -> bool:
        """True if there is an updated model, False if the method only locates errors."""
        return self.stiffness is not None

    @property
    def stopped_because(self) -> str:
        """Reason for the end, for readers."""
        if not self.corrects:
            return StopReason.LOCATED
        end = str(StopReason.SOLVED)
        if all(errors.max() < DIRECT_UPDATING.reproduction_error for errors in self.dof_errors.values()):
            end = f"{StopReason.UNCHANGED}: {end}"
        if self.converged:
            return end
        return f"{end}; measured shapes or frequencies are missed by {self.reproduced:.2g}"

    @property
    def ranked_errors(self) -> dict[str, tuple[DofError, ...]]:
        """Errors of all DoFs in falling order, by matrix."""
        return {
            matrix: tuple(DofError(dof, errors[dof]) for dof in self.ranked(matrix))
            for matrix, table in self.dof_errors.items()
            for errors in (dict(zip(self.dofs, table.tolist(), strict=True)),)
        }

    def ranked(self, matrix: str) -> tuple[Dof, ...]:
        """Return all DoFs in falling order of the error of a matrix."""
        return tuple(self.dofs[i] for i in (-self.dof_errors[matrix]).argsort(kind="stable"))
