"""What can be chosen, read from the families: a new member shows up with no other change."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path

from modallab.api.wire import Reply
from modallab.core.options import OptionSpec
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
# What a method may be told, of families that have options.
OFFERED: Mapping[FamilyName, Callable[[str], Mapping[str, OptionSpec]]] = {
    "extraction-methods": extraction.method_options,
    "updating-methods": updating.method_options,
}


Family = Annotated[FamilyName, Path(description="family of interchangeable parts")]


class MemberOut(Reply):
    """One choice: its kind, what it is, its parameters with unit and bounds."""

    kind: str
    """name in requests"""
    summary: str
    """meaning in one line"""
    parameters: dict[str, dict[str, Any]]
    """parameters or options by name: `unit`, `lower`, `upper`, `doc`, `default` or `choices` where present"""


@router.get("/{family}", summary="List the members of a family")
def list_members(family: Family) -> list[MemberOut]:
    """Return the members of a family, with unit and bounds of their parameters."""
    return [
        MemberOut(kind=kind, summary=_summary(member), parameters=_parameters(family, kind, member))
        for kind, member in FAMILIES[family].items()
    ]


def _summary(member: Any) -> str:
    summary = getattr(member, "summary", None)
    return summary if isinstance(summary, str) else (inspect.getdoc(member) or "").split("\n")[0]


def _parameters(family: FamilyName, kind: str, member: Any) -> dict[str, dict[str, Any]]:
    if options := OFFERED.get(family):
        return {name: asdict(spec) for name, spec in options(kind).items()}
    specs = getattr(member, "specs", None)
    return {} if specs is None else {name: asdict(spec) for name, spec in specs().items()}
