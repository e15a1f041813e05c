"""Domain type <-> (JSON row, named arrays): one pair of functions a kind."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, TypeVar

from numpy.typing import NDArray

from modallab.core.modal_model import ModalModel
from modallab.fe.structure import Structure
from modallab.store.plain import Arrays, Json, from_plain, to_plain

T = TypeVar("T")


@dataclass(frozen=True)
class Codec(Generic[T]):
    """How things of one kind are taken apart for the store and put together again."""

    take_apart: Callable[[T], tuple[Json, Arrays]]
    put_together: Callable[[Json, Mapping[str, NDArray[Any]]], T]


def _plain(cls: type[T]) -> Codec[T]:
    return Codec(to_plain, partial(from_plain, cls))


CODECS: Mapping[str, Codec[Any]] = {
    "structure": _plain(Structure),
    "modal_model": _plain(ModalModel),
}
