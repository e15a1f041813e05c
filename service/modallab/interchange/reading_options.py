"""Options of reading FRFs from files: facts that a file does not contain or states in its own words."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind
from modallab.interchange.settings import READING
from modallab.interchange.units import FrfUnit, frf_unit

ROLES = (
    "freq",
    "values",
    "real",
    "imag",
    "magnitude",
    "phase",
    "coherence",
    "outputs",
    "inputs",
    "output_directions",
    "input_directions",
    "kind",
    "averages",
    "force_spectrum",
    "response_spectrum",
    "force_cross_spectra",
)
ROLE_SYNONYMS = {
    "H": "values",
    "frf": "values",
    "frequency": "freq",
    "response": "outputs",
    "force": "inputs",
}
_COLUMN_ROLES = ("freq", "values", "real", "imag", "magnitude", "phase", "coherence")
_SIDES = ("response", "force")
ColumnName = str | int


@dataclass(frozen=True)
class ReadingOptions:
    """Facts that the files of a test do not contain, or state in their own words; empty if they are clear."""

    unit: str = ""
    """Unit of the FRFs in the file: `g/N`, `(m/s^2)/lbf`, `mm/s/N`."""
    scale: float | Mapping[str, float] = 1.0
    """Factor of the FRFs, or factors of `response` and `force`, to `unit`, or else to SI."""
    kind: FrfKind | None = None
    """Kind of the FRFs, if neither the file nor `unit` states it."""
    map: Mapping[str, str] = field(default_factory=dict)
    """DoFs, or nodes, of the names of points in the file: `{"wing_tip": "12:+Z"}`."""
    outputs: tuple[str, ...] = ()
    """Response DoFs of the FRFs, in the order of the file."""
    inputs: tuple[str, ...] = ()
    """Force DoFs of the FRFs, in the order of the file."""
    columns: Mapping[str, ColumnName | tuple[ColumnName, ...]] = field(default_factory=dict)
    """Columns of a text by role; names or numbers from 1."""
    variables: Mapping[str, str] = field(default_factory=dict)
    """Variables of a MATLAB, HDF5 or npz file by role: `{"freq": "f", "H": "frf"}`."""

    def __post_init__(self) -> None:
        plain = {ROLE_SYNONYMS.get(role, role): name for role, name in self.variables.items()}
        object.__setattr__(self, "variables", plain)
        columns = {
            ROLE_SYNONYMS.get(role, role): tuple(name) if isinstance(name, (list, tuple)) else (name,)
            for role, name in self.columns.items()
        }
        object.__setattr__(self, "columns", columns)
        for name, roles, allowed in (("variables", plain, ROLES), ("columns", columns, _COLUMN_ROLES)):
            unknown = [role for role in roles if role not in allowed]
            if unknown:
                raise InvalidInputError(
                    f"{name} has no role {unknown[0]!r}", field=name, value=unknown[0], allowed=list(allowed)
                )
        for names, options_field in ((self.outputs, "outputs"), (self.inputs, "inputs")):
            for name in names:
                Dof.parse(name, field=options_field)
        self._check_scale()
        if self.frf_unit is not None and self.kind not in (None, self.frf_unit.kind):
            raise InvalidInputError(
                f"{self.unit!r} is a unit of {self.frf_unit.kind}, and the kind is {self.kind}",
                field="unit",
                value=self.unit,
            )

    @property
    def frf_unit(self) -> FrfUnit | None:
        """The stated unit; None where there is none."""
        return frf_unit(self.unit) if self.unit else None

    @property
    def factors(self) -> tuple[float, float]:
        """SI units of the numbers 1 of response and of force in the file."""
        response, force = 1.0, 1.0
        if isinstance(self.scale, Mapping):
            response, force = (float(self.scale.get(side, 1.0)) for side in _SIDES)
        else:
            response = float(self.scale)
        unit = self.frf_unit
        return (response, force) if unit is None else (response * unit.response, force * unit.force)

    def as_json(self) -> dict[str, object]:
        """Return the options as JSON, for another process."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def _check_scale(self) -> None:
        scales = self.scale if isinstance(self.scale, Mapping) else {"response": self.scale}
        unknown = [side for side in scales if side not in _SIDES]
        if unknown:
            raise InvalidInputError(
                f"scale has no side {unknown[0]!r}", field="scale", value=unknown[0], allowed=list(_SIDES)
            )
        for value in scales.values():
            size = abs(value)
            if not (math.isfinite(value) and 1 / READING.max_scale <= size <= READING.max_scale):
                raise InvalidInputError(
                    "a scale is a factor of SI units, not 0",
                    field="scale",
                    value=value,
                    allowed=bounds(1 / READING.max_scale, READING.max_scale),
                )


def options_from_json(tree: Mapping[str, object]) -> ReadingOptions:
    """Return options from their JSON."""
    values = dict(tree)
    values |= {name: tuple(values[name]) for name in ("outputs", "inputs")}  # type: ignore[arg-type]
    values["kind"] = None if values["kind"] is None else FrfKind(values["kind"])  # type: ignore[arg-type]
    return ReadingOptions(**values)  # type: ignore[arg-type]


NO_OPTIONS = ReadingOptions()
