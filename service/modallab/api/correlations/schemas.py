"""Wire types of correlations."""

from typing import Self

from pydantic import Field

from modallab.api.deps import Id
from modallab.api.wire import Count, EntryOut, Wire
from modallab.correlation.compare import Correlation
from modallab.store.base import Entry


class CorrelationIn(Wire):
    """Measured modes against the first `count` elastic modes of a structure, as many by default."""

    modal_model_id: Id
    structure_id: Id
    count: Count | None = Field(None, ge=1, le=100)


class CorrelationOut(EntryOut):
    """MAC (measured, model); pairs (measured, model) counted from 1; differences in Hz by pair."""

    mac: list[list[float]]
    pairs: list[tuple[int, int]]
    frequency_differences: list[float]
    comac: list[float]
    dofs: list[str]

    @classmethod
    def of(cls, correlation: Correlation, entry: Entry) -> Self:
        """Return what the contract shows of a correlation."""
        return cls(
            **cls.fields(entry),
            mac=correlation.mac.tolist(),
            pairs=[(measured + 1, model + 1) for measured, model in correlation.pairs],
            frequency_differences=correlation.frequency_differences.tolist(),
            comac=correlation.comac.tolist(),
            dofs=[str(dof) for dof in correlation.dofs],
        )
