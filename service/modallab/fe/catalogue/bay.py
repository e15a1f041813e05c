"""The bay of the 1992 thesis, appendix B.3 and table 2.1: a rectangle with one diagonal."""

from modallab.fe.catalogued import STRUCTURES
from modallab.fe.frame_builder import frame_along
from modallab.fe.structure import Structure


@STRUCTURES.register("bay")
def bay() -> Structure:
    """A free aluminium frame, one bay of 5 m by 3 m with a diagonal: 31 members, 90 DoFs, undamped."""
    return frame_along([(0, 0), (5, 0), (5, 3), (0, 3), (0, 0), (5, 3)], name="bay")
