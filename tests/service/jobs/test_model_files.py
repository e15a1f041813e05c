"""Models of hostile files: refused in time, and without the memory of whoever asked."""

import io
import resource
import time

import pytest

from modallab.core.errors import InvalidInputError
from modallab.fe.beam import beam
from modallab.fe.structure import Material, Section
from modallab.interchange.mesh.description import MeshDescription
from modallab.interchange.model_reading import read_model
from modallab.jobs.model_files import ModelRequest, read_model_confined
from modallab.store.codec import CODECS
from tests.faults.heavy import ABAQUS, GMSH, VTK

DECK = b"""BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
CBAR,1,1,1,2,0.,0.,1.
PBAR,1,1,1e-3,1e-8,1e-8,1e-8
MAT1,1,2.1e11,,.3,7800.
ENDDATA
"""


@pytest.mark.parametrize("text", [ABAQUS, VTK, GMSH], ids=["abaqus", "vtk", "gmsh"])
def test_a_small_file_that_unfolds_to_gigabytes_is_refused(text: str) -> None:
    begin = time.monotonic()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(InvalidInputError, match="larger inside than outside") as raised:
        read_model_confined(
            io.BytesIO(text.encode()),
            ModelRequest(description=MeshDescription(groups={})),
            largest=10_000_000,
        )
    assert raised.value.context["field"] == "file"
    assert time.monotonic() - begin < 120  # 3 s of processor time, on however busy a machine
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000  # kB


def test_a_model_is_the_same_as_read_in_this_process() -> None:
    here = read_model(io.BytesIO(DECK), largest=10_000, name="bar")
    there = read_model_confined(io.BytesIO(DECK), ModelRequest(name="bar"), largest=10_000)
    assert CODECS["structure"].take_apart(there)[0] == CODECS["structure"].take_apart(here)[0]


def test_damping_travels_to_the_process_that_reads() -> None:
    damping = beam(
        length=1.0,
        n_elements=1,
        section=Section(area=1e-4, second_moment=1e-9),
        material=Material(modulus=2e11, density=7800.0),
    ).damping
    read = read_model_confined(io.BytesIO(DECK), ModelRequest(damping=damping), largest=10_000)
    assert read.damping == damping
