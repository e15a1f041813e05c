"""Common wire types: strict models, DoFs, effects, entries of the store."""

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, StringConstraints
from typing_extensions import TypeAliasType

from modallab.api.limits import REQUEST
from modallab.api.schema import Limits, NamedByPattern, OneOf, Pattern
from modallab.core.dof import Dof
from modallab.core.frequency_table import MAX_ROWS
from modallab.core.place import Channels, Dofs, EffectSpec, Members, Place
from modallab.fe.structure_settings import INPUT
from modallab.rig.effect import EFFECTS, Effect, build
from modallab.store.base import Entry


def _refuse_conversion(value: Any) -> Any:
    if isinstance(value, (bool, str)):
        raise ValueError("Input should be a number")
    return value


# `true` and "20" are mistakes of the sender: reading them as numbers would hide that. This validator
# stands last in every number's type: bounds that follow it are lost to the JSON schema.
NO_CONVERSION = BeforeValidator(_refuse_conversion)
# A number beyond this has no meaning in any unit used here, and would overflow in the first product.
Number = Annotated[float, Field(ge=-REQUEST.real, le=REQUEST.real), NO_CONVERSION]
Count = Annotated[int, Field(ge=-REQUEST.integer, le=REQUEST.integer), NO_CONVERSION]
Positive = Annotated[Number, Limits(INPUT.min_positive, INPUT.max_property)]
NonNegative = Annotated[Number, Limits(0.0, INPUT.max_property)]
Fraction = Annotated[Number, Limits(0.0, 1.0)]
NodeNumber = Annotated[Count, Limits(1, 999_999_999)]
NoiseFloor = Annotated[float, Field(gt=0, le=1), NO_CONVERSION]
ModeCount = Annotated[int, Field(ge=1, le=100), NO_CONVERSION]
ID_PATTERN = r"^[A-Za-z0-9_-]{1,64}$"
Text = Annotated[str, StringConstraints(max_length=100, pattern=r"^[^\x00]*$")]
HolderName = Annotated[str, StringConstraints(min_length=1, max_length=100, pattern=r"^[^\x00-\x1f]+$")]
DofText = Annotated[
    str,
    StringConstraints(max_length=20, pattern=r"^[^\x00]*$"),
    Field(description="degree of freedom as `node:direction`, for example `5:+Y`"),
    Pattern(r"^[0-9]{1,9}:[+-]?R?[XYZ]$"),
]
Translation = Annotated[DofText, Pattern(r"^[0-9]{1,9}:[+-]?[XYZ]$")]
Seed = Annotated[int, Field(ge=0, le=2**63 - 1), NO_CONVERSION]


EffectKind = TypeAliasType("EffectKind", Annotated[Text, OneOf(lambda: EFFECTS, "effect, of the catalogue")])


class Wire(BaseModel):
    """A request's part: unknown fields and numbers that are not finite are refused."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True, use_attribute_docstrings=True)


class Wanted(BaseModel):
    """Query parameters of a reply that is computed at once."""

    model_config = ConfigDict(use_attribute_docstrings=True)


class MembersAt(Wire):
    """Members of the structure by number."""

    members: list[NodeNumber] = Field(min_length=1, max_length=20_000)
    """numbers of members"""


class DofsAt(Wire):
    """Degrees of freedom at which equal parts act."""

    dofs: list[DofText] = Field(min_length=1, max_length=1000)
    """degrees of freedom of the structure"""


class ChannelsAt(Wire):
    """Response channels by the DoF each measures."""

    channels: list[DofText] = Field(min_length=1, max_length=1000)
    """response degrees of freedom of the channels"""


class EffectIn(Wire):
    """An effect: its kind, where it acts (null: everywhere), its parameters in SI units."""

    kind: EffectKind
    """name of the effect; `GET /v1/catalog/effects` lists them"""
    at: DofText | DofsAt | MembersAt | ChannelsAt | None = None
    """degree or degrees of freedom, members or channels where the effect acts; null: everywhere"""
    parameters: Annotated[dict[Text, Number], NamedByPattern()] = Field(default_factory=dict, max_length=20)
    """numbers of the effect by name, SI units; left out: the defaults of the catalogue"""

    table: tuple[tuple[Number, Number, Number], ...] = Field(default=(), max_length=MAX_ROWS)
    """curve of a tabulated effect: rows of frequency in Hz, real part and imaginary part; left out: the
    default of the catalogue, or no tabulated effect"""

    def to_domain(self) -> Effect:
        """Return the effect, its kind, parameters, table and bounds checked."""
        return build(self.spec())

    def spec(self) -> EffectSpec:
        """Return the effect as it was sent, unchecked."""
        return EffectSpec(self.kind, self.place(), self.parameters, self.table)

    def place(self) -> Place:
        """Return where the effect acts."""
        match self.at:
            case DofsAt():
                return Dofs(tuple(Dof.parse(text, field="at") for text in self.at.dofs))
            case MembersAt():
                return Members(tuple(self.at.members))
            case ChannelsAt():
                return Channels(tuple(Dof.parse(text, field="at") for text in self.at.channels))
            case None:
                return None
            case text:
                return Dof.parse(text, field="at")


Effects = Annotated[tuple[EffectIn, ...], Field(max_length=50)]


def place_out(place: Place) -> str | dict[str, Any] | None:
    """Return where an effect acts, as the contract writes it."""
    match place:
        case Dofs():
            return {"dofs": [str(dof) for dof in place.dofs]}
        case Members():
            return {"members": list(place.numbers)}
        case Channels():
            return {"channels": [str(dof) for dof in place.dofs]}
        case None:
            return None
        case dof:
            return str(dof)


def effect_out(spec: EffectSpec) -> dict[str, Any]:
    """Return an effect as the contract writes it."""
    body = {"kind": spec.kind, "at": place_out(spec.at), "parameters": dict(spec.parameters)}
    return body | {"table": [list(row) for row in spec.table]} if spec.table else body


class Reply(BaseModel):
    """Base of replies; values are read from the attributes of domain types."""

    model_config = ConfigDict(from_attributes=True, frozen=True, use_attribute_docstrings=True)


class StoredEntry(Reply):
    """Identity and origin of a stored object."""

    id: str
    """id of the stored object"""
    owner: str
    """id of the key that it was made with; `local`: made without keys"""
    created: str
    """time of creation, ISO 8601, UTC"""
    version: str
    """version of the service that made it"""
    seed: int | None
    """seed of its random numbers; null where there are none"""
    made_from: Mapping[str, str]
    """ids of the objects it was made from, by role"""
    name: str
    """name, as its owner wrote it; a structure's own until then"""
    labels: tuple[str, ...]
    """labels by which its owner finds it"""
    comment: str
    """what its owner remarks on it"""

    @staticmethod
    def fields(entry: Entry) -> dict[str, Any]:
        """Return the fields that every answer shares."""
        return {
            "id": entry.id,
            "owner": entry.owner,
            "created": entry.created,
            "version": entry.version,
            "seed": entry.seed,
            "made_from": entry.inputs,
            "name": entry.name,
            "labels": tuple(entry.labels),
            "comment": entry.comment,
        }
