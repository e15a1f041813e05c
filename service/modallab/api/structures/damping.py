"""Wire types of damping laws."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, TypeAdapter, ValidationError

from modallab.api.faults import wrong_json
from modallab.api.schema import Limits
from modallab.api.wire import Number, Wire
from modallab.core.errors import StructureError
from modallab.fe.damping import Damping, ModalDamping, StructuralDamping, UnknownDamping, ViscousDamping
from modallab.fe.structure_settings import INPUT

DampingCoefficient = Annotated[Number, Limits(0.0, INPUT.max_damping)]


class StructuralIn(Wire):
    """D = a M + b K."""

    law: Literal["structural"]
    """`structural`: hysteretic damping"""
    stiffness_coefficient: DampingCoefficient = 0.0
    """1, b of D = a M + b K"""
    mass_coefficient: DampingCoefficient = 0.0
    """(rad/s)^2, a of D = a M + b K"""

    def to_domain(self) -> Damping:
        """Return the damping law."""
        return StructuralDamping(self.stiffness_coefficient, self.mass_coefficient)


class ViscousIn(Wire):
    """C = a M + b K."""

    law: Literal["viscous"]
    """`viscous`: proportional viscous damping"""
    stiffness_coefficient: DampingCoefficient = 0.0
    """s, b of C = a M + b K"""
    mass_coefficient: DampingCoefficient = 0.0
    """1/s, a of C = a M + b K"""

    def to_domain(self) -> Damping:
        """Return the damping law."""
        return ViscousDamping(self.stiffness_coefficient, self.mass_coefficient)


Ratios = DampingCoefficient | Annotated[list[DampingCoefficient], Field(min_length=1, max_length=1000)]


class ModalIn(Wire):
    """Loss factors or damping ratios of the elastic modes: one for all, or a list from the lowest."""

    law: Literal["modal"]
    """`modal`: damping mode by mode"""
    loss_factors: Ratios | None = None
    """1, loss factors, one for all elastic modes or a list from the lowest; give these or `damping_ratios`"""
    damping_ratios: Ratios | None = None
    """1, viscous damping ratios, one for all elastic modes or a list from the lowest"""

    def to_domain(self) -> Damping:
        """Return the damping law."""
        if (self.loss_factors is None) == (self.damping_ratios is None):
            raise StructureError(
                "modal damping takes loss factors or damping ratios",
                field="damping",
                allowed="one of loss_factors, damping_ratios",
            )
        given, scale = (self.damping_ratios, 2.0) if self.loss_factors is None else (self.loss_factors, 1.0)
        values = given if isinstance(given, list) else [given]
        return ModalDamping(tuple(scale * value for value in values if value is not None))


class UnknownIn(Wire):
    """Unknown damping."""

    law: Literal["unknown"]
    """`unknown`: 0.01 of every mode, where a number is needed; free, mode by mode, in a diagnosis"""

    def to_domain(self) -> Damping:
        """Return the damping law."""
        return UnknownDamping()


def _spelt_out(value: object) -> object:
    return {"law": "unknown"} if value == "unknown" else value


DampingLawIn = StructuralIn | ViscousIn | ModalIn | UnknownIn
DampingIn = Annotated[DampingLawIn, Field(discriminator="law")]
DampingOrWord = Annotated[DampingIn, BeforeValidator(_spelt_out)]


def damping_of(text: str) -> Damping:
    """Return the damping law that a form's field writes as JSON.

    Raises
    ------
    InvalidInputError
        If it is none.
    """
    adapter: TypeAdapter[DampingLawIn] = TypeAdapter(DampingIn)
    try:
        return adapter.validate_json(text).to_domain()
    except ValidationError as error:
        raise wrong_json(error, adapter, text, "damping") from None
