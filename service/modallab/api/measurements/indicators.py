"""What FRFs show before any fit: where modes are, and whether force and response may change places."""

from typing import Self

import numpy as np
from pydantic import Field

from modallab.api.limits import REPLY
from modallab.api.thinning import numbers, thinned
from modallab.api.wire import Reply
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind
from modallab.extraction.preprocessing.indicators import complex_mode_indicator, real_part_indicator
from modallab.extraction.preprocessing.reciprocity import reciprocity
from modallab.rig.measurement import Measurement


class IndicatorsOut(Reply):
    """Mode indicator functions of mobility, thinned; dips of `mif` and peaks of `cmif` are modes."""

    freq: list[float] = Field(description="Hz, above 0")
    inputs: list[str]
    """force degrees of freedom"""
    mif: list[list[float]] = Field(description="a force: 0 where all responses are in phase with it, to 1")
    cmif: list[list[float]] = Field(description="singular values in m/(s N), the largest first")

    @classmethod
    def of(cls, measurement: Measurement, points: int) -> Self:
        """Return the indicators at about `points` lines.

        Raises
        ------
        InvalidInputError
            If the reply would hold more numbers than JSON is good for.
        """
        frf = measurement.frf.between(0.0, np.inf).to(FrfKind.MOBILITY)
        mif, cmif = real_part_indicator(frf), complex_mode_indicator(frf)
        peaks, dips = thinned(cmif, points), thinned(mif, points)
        keep = np.union1d(peaks, dips)  # a dip of one need be no peak of the other
        if len(keep) * (mif.shape[1] + cmif.shape[1]) > REPLY.json_curve_values:
            raise InvalidInputError(
                "these curves are too long for JSON: take fewer points",
                field="points",
                value=points,
                allowed=bounds(maximum=REPLY.json_curve_values // (2 * (mif.shape[1] + cmif.shape[1]))),
            )
        return cls(
            freq=frf.freq[keep].tolist(),
            inputs=[str(dof) for dof in frf.inputs],
            mif=mif[keep].T.tolist(),
            cmif=cmif[keep].T.tolist(),
        )


class ReciprocalPairOut(Reply):
    """Two FRFs between the same points: H_jk, response at j, and H_kj."""

    response: str
    """degree of freedom j"""
    force: str
    """degree of freedom k"""
    scale: tuple[float | None, float | None] = Field(
        description="H_jk = scale H_kj: 1 if reciprocal, [re, im]"
    )
    difference: float = Field(description="rms of H_jk - H_kj over that of their mean")
    misfit: float | None = Field(description="mean square over the random one; null where that is not known")
    differs: bool = Field(description="beyond random error")


class ReciprocityOut(Reply):
    """How far FRFs between the same points differ, and what the data allow to say."""

    pairs: list[ReciprocalPairOut]
    """pairs of FRFs with force and response exchanged"""
    note: str
    """limits of the comparison"""

    @classmethod
    def of(cls, measurement: Measurement) -> Self:
        """Return what the contract shows of reciprocity."""
        frf, g2 = measurement.frf, measurement.coherence
        # a multiple coherence is of all forces together: it tells no FRF's own error
        coherence = g2 if g2 is not None and g2.shape == frf.values.shape else None
        comparison = reciprocity(frf, coherence=coherence, averages=measurement.averages)
        columns = (comparison.scale, comparison.difference, comparison.misfit, comparison.differs)
        return cls(
            pairs=[
                ReciprocalPairOut(
                    response=str(j),
                    force=str(k),
                    scale=scale,
                    difference=difference,
                    misfit=misfit,
                    differs=differs,
                )
                for (j, k), scale, difference, misfit, differs in zip(
                    comparison.pairs, *(numbers(column) for column in columns), strict=True
                )
            ],
            note=comparison.note,
        )
