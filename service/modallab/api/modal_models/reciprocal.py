"""Modal constants of two tests that exchange drive point and response."""

from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import Query

from modallab.api.deps import Id
from modallab.api.replies import reply_of
from modallab.core.modal_model import ModalModel
from modallab.core.reply import NanFloat
from modallab.extraction.preprocessing.reciprocity import modal_reciprocity

OTHER = Annotated[Id, Query(description="the modal model of the other test")]


@dataclass(frozen=True)
class ModalPair:
    """Comparison of the modal constants of one mode in both tests."""

    modes: tuple[int, int]
    """Numbers of the mode in this model and in the other, from 1."""
    ratio: complex
    """Modal constant of this model over that of the other: 1 if reciprocal."""
    ratio_error: NanFloat
    """Standard error of the real and of the imaginary part; None where the constants have none."""
    differs: bool
    """Whether the ratio differs from 1 by more than its standard error explains."""


@dataclass(frozen=True)
class ModalReciprocityCheck:
    """Comparison of modes of two tests that exchange drive point and response."""

    pairs: tuple[ModalPair, ...]
    """One comparison a mode that both tests show."""


ModalReciprocityReply: Any = reply_of(ModalReciprocityCheck)


def modal_reciprocity_of(first: ModalModel, second: ModalModel) -> ModalReciprocityCheck:
    """Return the comparison of modal constants by mode.

    Raises
    ------
    InvalidInputError
        If either test has no response at the drive point of the other.
    """
    result = modal_reciprocity(first, second)
    columns = (column.tolist() for column in (result.ratio, result.ratio_error, result.differs))
    pairs = zip(result.pairs, *columns, strict=True)
    return ModalReciprocityCheck(
        tuple(ModalPair((i + 1, j + 1), ratio, error, differs) for (i, j), ratio, error, differs in pairs)
    )
