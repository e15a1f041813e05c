"""Pseudo-random excitation."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.rig.excitation import EXCITATIONS, Excitation


def phases(n_lines: int) -> FloatArray:
    """Return phases without order, rad, (n_lines,): 2 pi sqrt(2) k^3, as a stored sequence has them.

    Evenly spread and uncorrelated from line to line (Weyl's theorem on polynomials), and the same
    whenever the sequence is played.
    """
    line = np.arange(n_lines)
    return np.asarray(2 * np.pi * ((np.sqrt(2.0) * line**3) % 1.0))


EXCITATIONS.register("pseudo_random")(
    Excitation(
        summary="one record of lines of equal size and random phase, played again and again: no leakage",
        phases=phases,
    )
)
