"""What a direct method found, and how good it is."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from modallab.core.arrays import FloatArray, frozen
from modallab.core.dof import Dof
from modallab.updating.direct.settings import DIRECT_UPDATING


@dataclass(frozen=True, eq=False)
class MeasuredModes:
    """Each measured mode beside the nearest one of the model, before and after; those used come first."""

    n_used: int
    measured: FloatArray  # (n_measured,) Hz
    before: FloatArray  # (n_measured,) Hz
    mac_before: FloatArray  # (n_measured,)
    after: FloatArray | None  # (n_measured,) Hz; None where nothing was corrected
    mac_after: FloatArray | None

    def __post_init__(self) -> None:
        for name in ("measured", "before", "mac_before", "after", "mac_after"):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, frozen(value, float, (len(self.measured),), name=name))


@dataclass(frozen=True, eq=False)
class OtherModes:
    """The model's elastic modes that no measured one was used for, and what the correction made of them.

    Frequencies below zero stand for a stiffness that pushes away: -sqrt(-omega^2) / 2 pi.
    """

    before: FloatArray  # (k,) Hz, rising
    after: FloatArray  # (k,) Hz
    mac: FloatArray  # (k,)
    # Hz, highest at which the corrected matrices hold a motion that was free; None where none was
    rigid_body: float | None

    def __post_init__(self) -> None:
        for name in ("before", "after", "mac"):
            object.__setattr__(self, name, frozen(getattr(self, name), float, (len(self.before),), name=name))


@dataclass(frozen=True, eq=False)
class DirectResult:
    """What a direct method found, at the degrees of freedom it worked at."""

    method: str
    dofs: tuple[Dof, ...]
    completion: str  # how model and shapes came to the same DoFs, in words
    mass: FloatArray | None  # (n, n) kg, updated; None where the method locates only
    stiffness: FloatArray | None  # (n, n) N/m
    # (n, n) by matrix: what was added to it, or is estimated to be wrong with it
    errors: Mapping[str, FloatArray]
    dof_errors: Mapping[str, FloatArray]  # (n,) by matrix, of each DoF
    # by matrix: norm of the correction where the structure connects nothing over its whole norm
    connectivity_loss: Mapping[str, float]
    modes: MeasuredModes
    other_modes: OtherModes | None  # None where nothing was corrected
    reproduced: float | None  # largest relative error of a used frequency, or 1 - MAC
    notes: tuple[str, ...] = field(default=())
    # by part and member, 1 = no change; of methods that keep the members
    coefficients: Mapping[str, Mapping[int, float]] = field(default_factory=dict)

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
        """True if there is an updated model and it has the measured modes."""
        return self.reproduced is not None and self.reproduced < DIRECT_UPDATING.reproduction_error

    @property
    def corrects(self) -> bool:
        """True if there is an updated model, False if the method only locates errors."""
        return self.stiffness is not None

    def ranked(self, matrix: str) -> tuple[Dof, ...]:
        """Return all DoFs, those where a matrix is most in error first."""
        return tuple(self.dofs[i] for i in (-self.dof_errors[matrix]).argsort(kind="stable"))
