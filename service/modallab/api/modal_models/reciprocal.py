"""Modal constants of two tests that drive at each other's response."""

from typing import Annotated, Self

from fastapi import Query
from pydantic import BaseModel, Field

from modallab.api.deps import Id
from modallab.api.thinning import numbers
from modallab.core.modal_model import ModalModel
from modallab.extraction.preprocessing.reciprocity import modal_reciprocity

OTHER = Annotated[Id, Query(description="the modal model of the other test")]


class ModalPairOut(BaseModel):
    """One mode as both tests see it."""

    modes: tuple[int, int] = Field(description="of this model and of the other, counted from 1")
    ratio: tuple[float | None, float | None] = Field(
        description="modal constant of this over that of the other: 1 if reciprocal, [re, im]"
    )
    ratio_error: float | None = Field(description="standard error of either part")
    differs: bool = Field(description="beyond its standard error")


class ModalReciprocityOut(BaseModel):
    """How far modal constants agree when force and response change places."""

    pairs: list[ModalPairOut]

    @classmethod
    def of(cls, first: ModalModel, second: ModalModel) -> Self:
        """Return what the contract shows; `InvalidInputError` if neither drives where the other listens."""
        found = modal_reciprocity(first, second)
        columns = (numbers(column) for column in (found.ratio, found.ratio_error, found.differs))
        return cls(
            pairs=[
                ModalPairOut(modes=(i + 1, j + 1), ratio=ratio, ratio_error=error, differs=differs)
                for (i, j), ratio, error, differs in zip(found.pairs, *columns, strict=True)
            ]
        )
