"""Catalogue of interchangeable parts: effects, structures, excitations, methods and the like."""

import inspect
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path
from pydantic import Field

from modallab.api.replies import reply
from modallab.api.wire import Reply
from modallab.core.options import OptionSpec
from modallab.core.parameters import ParameterSpec
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.windows import WINDOWS
from modallab.extraction import method_options as extraction
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS
from modallab.extraction.single_mode.method import EXTRACTION_METHODS
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.reduction import REDUCTIONS
from modallab.rig.effect import EFFECTS
from modallab.rig.excitation import EXCITATIONS
from modallab.updating import method_options as updating

router = APIRouter(prefix="/catalog", tags=["catalog"])

FamilyName = Literal[
    "effects",
    "structures",
    "excitations",
    "windows",
    "estimators",
    "extraction-methods",
    "updating-methods",
    "reductions",
]
FAMILIES: Mapping[FamilyName, Mapping[str, Any]] = {
    "effects": EFFECTS,
    "structures": STRUCTURES,
    "excitations": EXCITATIONS,
    "windows": WINDOWS,
    "estimators": ESTIMATORS,
    "extraction-methods": {**EXTRACTION_METHODS, **GLOBAL_METHODS},
    "updating-methods": updating.METHODS,
    "reductions": REDUCTIONS,
}
# Options of the members, of families that have options.
OPTION_SPECS: Mapping[FamilyName, Callable[[str], Mapping[str, OptionSpec]]] = {
    "extraction-methods": extraction.method_options,
    "updating-methods": updating.method_options,
}


Family = Annotated[FamilyName, Path(description="family of interchangeable parts")]


_KIND = "Type of this specification."
Parameter: Any = reply(ParameterSpec, "ParameterSpec", kind=(Literal["parameter"], _KIND))
Option: Any = reply(OptionSpec, "OptionSpec", kind=(Literal["option"], _KIND))


class CatalogueEntry(Reply):
    """Member of a family of the catalogue, with unit and bounds of its parameters."""

    kind: str
    """Name in requests."""
    summary: str
    """Meaning in one line."""
    parameters: dict[str, Annotated[Parameter | Option, Field(discriminator="kind")]]
    """Parameters or options by name."""


@router.get("/{family}", summary="List the members of a family")
def list_members(family: Family) -> list[CatalogueEntry]:
    """Return the members of a family of interchangeable parts, with unit and bounds of their parameters."""
    return [
        CatalogueEntry(kind=kind, summary=_summary(member), parameters=_parameters(family, kind, member))
        for kind, member in FAMILIES[family].items()
    ]


def _summary(member: Any) -> str:
    summary = getattr(member, "summary", None)
    return summary if isinstance(summary, str) else (inspect.getdoc(member) or "").split("\n")[0]


def _parameters(family: FamilyName, kind: str, member: Any) -> dict[str, Any]:
    if options := OPTION_SPECS.get(family):
        return dict(options(kind))
    specs = getattr(member, "specs", None)
    return {} if specs is None else dict(specs())
