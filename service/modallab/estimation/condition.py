"""Condition of the input matrix of several exciters."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.errors import InvalidInputError
from modallab.estimation.settings import SPECTRUM
from modallab.estimation.spectra import CrossSpectra


def input_condition(spectra: CrossSpectra) -> FloatArray:
    """Return the condition number of the input matrix G_ff, (n_run, n_freq); 1 with one force.

    The ratio of the greatest to the least virtual force (the eigenvalues of G_ff): relative errors of the
    spectra may grow by as much in H1 = G_ff^-1 G_fx. At most 1/epsilon of double precision, where the
    forces are one. Allemang, Rost and Brown, 2nd IMAC (1984).
    """
    virtual = np.linalg.eigvalsh(spectra.ff)
    greatest, least = virtual[..., -1], virtual[..., 0]
    tiny = np.finfo(float).eps * greatest
    return np.asarray(np.where(greatest > 0, greatest, 1.0) / np.where(greatest > 0, least.clip(tiny), 1.0))


def independent_condition(spectra: CrossSpectra) -> FloatArray:
    """Return `input_condition` of linearly independent forces, (n_run, n_freq).

    Raises
    ------
    InvalidInputError
        If they are not independent of each other at some line.
    """
    condition = input_condition(spectra)
    if condition.max() > SPECTRUM.max_input_condition:
        raise InvalidInputError(
            "the forces that act at once are not independent of each other",
            field="excitation.kind",
            value=f"condition number {condition.max():.3g} of the input matrix",
            allowed="exciters whose signals have nothing in common",
        )
    return condition
