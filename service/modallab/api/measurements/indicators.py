"""Checks of FRFs before extraction: mode indicator functions and reciprocity."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from modallab.api.limits import REPLY
from modallab.api.replies import reply_of
from modallab.api.thinning import thinned
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind
from modallab.core.reply import Matrix, NanFloat, Vector
from modallab.extraction.preprocessing.indicators import complex_mode_indicator, real_part_indicator
from modallab.extraction.preprocessing.reciprocity import reciprocity
from modallab.rig.measurement import Measurement


@dataclass(frozen=True, eq=False)
class Indicators:
    """Mode indicator functions of mobility, thinned; minima of `mif` and peaks of `cmif` are modes."""

    freq: Vector
    """Hz, (n_lines,) lines above 0."""
    inputs: tuple[Dof, ...]
    """Force DoFs."""
    mif: Matrix
    """(n_in, n_lines) mode indicator function (MIF): 0 where all responses are in phase with the force."""
    cmif: Matrix
    """m/(s N), (n_values, n_lines) complex mode indicator function (CMIF): singular values, descending."""


@dataclass(frozen=True)
class ReciprocalPair:
    """Comparison of two FRFs between the same points: H_jk, response at j, and H_kj."""

    response: Dof
    """DoF j."""
    force: Dof
    """DoF k."""
    scale: complex
    """Least-squares factor in H_jk = scale H_kj: 1 if reciprocal, -1 if a sign is wrong."""
    difference: float
    """Root mean square of H_jk - H_kj over that of their mean."""
    misfit: NanFloat
    """Mean of |H_jk - H_kj|^2 over its variance: 1 for random error only; None where that is unknown."""
    differs: bool
    """Whether the difference exceeds the random error."""


@dataclass(frozen=True)
class ReciprocityCheck:
    """Comparison of FRFs whose force and response are exchanged."""

    pairs: tuple[ReciprocalPair, ...]
    """One comparison a pair of points."""
    note: str
    """Statement of the pairs that the data contain."""


IndicatorsReply: Any = reply_of(Indicators)
ReciprocityReply: Any = reply_of(ReciprocityCheck)


def indicators_of(measurement: Measurement, points: int) -> Indicators:
    """Return the mode indicator functions at about `points` lines.

    Raises
    ------
    InvalidInputError
        If the reply would hold more numbers than JSON is good for.
    """
    frf = measurement.frf.between(0.0, np.inf).to(FrfKind.MOBILITY)
    mif, cmif = real_part_indicator(frf), complex_mode_indicator(frf)
    lines = np.union1d(
        thinned(cmif, points), thinned(mif, points)
    )  # a minimum of one need be no peak of the other
    n_curves = mif.shape[1] + cmif.shape[1]
    if len(lines) * n_curves > REPLY.json_curve_values:
        raise InvalidInputError(
            "these curves are too long for JSON: take fewer points",
            field="points",
            value=points,
            allowed=bounds(maximum=REPLY.json_curve_values // (2 * n_curves)),
        )
    return Indicators(frf.freq[lines], frf.inputs, mif[lines].T, cmif[lines].T)


def reciprocity_of(measurement: Measurement) -> ReciprocityCheck:
    """Return the comparison of FRFs whose force and response are exchanged."""
    result = reciprocity(measurement.frf, coherence=measurement.frf_coherence, averages=measurement.averages)
    columns = (result.scale, result.difference, result.misfit, result.differs)
    pairs = tuple(
        ReciprocalPair(j, k, scale, difference, misfit, differs)
        for (j, k), scale, difference, misfit, differs in zip(
            result.pairs, *(column.tolist() for column in columns), strict=True
        )
    )
    return ReciprocityCheck(pairs, result.note)
