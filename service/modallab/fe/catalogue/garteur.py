"""The GARTEUR frame of the 1992 thesis, section 3.6: three bays in a row."""

from modallab.fe.catalogued import STRUCTURES
from modallab.fe.frame_builder import frame_along
from modallab.fe.structure import Structure


@STRUCTURES.register("garteur")
def garteur() -> Structure:
    """A free aluminium frame, three bays with parallel diagonals: 83 members, 234 DoFs, undamped."""
    outline = [(0, 0), (0, 3), (15, 3), (15, 0), (0, 0)]
    return frame_along([*outline, (5, 3), (5, 0), (10, 3), (10, 0), (15, 3)], name="garteur")
