"""List of contents of a project file, and the reply of its import."""

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field, StringConstraints

from modallab.api.deps import Id
from modallab.api.projects.settings import PROJECT
from modallab.api.shelves import Label
from modallab.api.wire import NO_CONVERSION, Reply, Text, Wire

Kind = Literal[
    "structure", "rig", "measurement", "modal_model", "correlation", "update", "study", "diagnosis"
]
Version = Annotated[str, StringConstraints(pattern=r"^[0-9A-Za-z.+-]{1,32}$")]
Role = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]{0,39}$")]


class ThingIn(Wire):
    """One object of a project file."""

    id: Id
    """id in the service that it is from"""
    kind: Kind
    """what it is"""
    version: Version
    """version of the service that made it"""
    seed: Annotated[int | None, Field(ge=-(2**63), lt=2**63), NO_CONVERSION]
    """seed of its random numbers"""
    inputs: dict[Role, Id]
    """ids of the objects it was made from, by role"""
    name: Text
    """name"""
    labels: Annotated[tuple[Label, ...], Field(max_length=20)]
    """labels by which it is found"""
    comment: Annotated[str, StringConstraints(max_length=2000, pattern=r"^[^\x00]*$")]
    """remark"""


class ProjectIn(Wire):
    """List of contents of a project file."""

    format: Literal[1]
    """layout of the file"""
    version: Version
    """version of the service that wrote it"""
    things: Annotated[tuple[ThingIn, ...], Field(max_length=PROJECT.max_things)]
    """objects, each after those that it was made from"""
    left_out: tuple[Id, ...]
    """ids of what was not written"""


class ImportedProject(Reply):
    """What was stored of a project file."""

    ids: Mapping[str, str]
    """ids of the stored objects by their ids in the file"""
    counts: Mapping[str, int]
    """number of stored objects by kind"""
