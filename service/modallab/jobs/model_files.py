"""Models from files of unknown origin, read by a process of little memory and time."""

from dataclasses import dataclass
from typing import BinaryIO

from modallab.fe.damping import Damping
from modallab.fe.structure import Structure
from modallab.interchange.confinement import NamedFile, run_confined
from modallab.interchange.mesh.description import MeshDescription
from modallab.store.codec import CODECS
from modallab.store.plain import to_plain

_MODULE = "modallab.jobs.model_process"


@dataclass(frozen=True)
class ModelRequest:
    """What is known of a model beside its file, see `interchange.model_reading.read_model`."""

    damping: Damping | None = None
    """Damping of the structure; None: what the file's elements have."""
    name: str = ""
    """Name of the structure."""
    description: MeshDescription | None = None
    """What the groups of a mesh are made of."""


def read_model_confined(file: BinaryIO, request: ModelRequest, *, largest: int) -> Structure:
    """Return the structure of a file, read by another process.

    Parameters
    ----------
    largest
        Bytes that the file, or its arrays, may take.

    Raises
    ------
    InvalidInputError
        As `read_model`, or if the file costs too much memory or time.
    """
    about, arrays = run_confined(
        _MODULE, (NamedFile("", file),), {"model": to_plain(request)[0]}, largest=largest
    )
    structure: Structure = CODECS["structure"].put_together(about["structure"], arrays)
    return structure
