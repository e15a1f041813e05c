"""Families: named sets of interchangeable parts, one file a part."""

import importlib
import pkgutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TypeVar

from modallab.core.errors import InvalidInputError

T = TypeVar("T")


class Family(Mapping[str, T]):
    """A named set of interchangeable parts, read like a dict; each file adds one."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._members: dict[str, T] = {}

    def register(self, kind: str) -> Callable[[T], T]:
        """Return a decorator that adds its target under `kind`."""

        def add(member: T) -> T:
            if kind in self._members:
                raise RuntimeError(f"{self.name} {kind!r} is registered twice")
            self._members[kind] = member
            return member

        return add

    def __getitem__(self, kind: str) -> T:
        if kind not in self._members:
            raise InvalidInputError(
                f"no {self.name} called {kind!r}", field=self.name, value=kind, allowed=", ".join(self)
            )
        return self._members[kind]

    def __contains__(self, kind: object) -> bool:
        return kind in self._members

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._members))

    def __len__(self) -> int:
        return len(self._members)


def discover(package: str, path: Iterable[str]) -> None:
    """Import every module of a package, so that its members register themselves."""
    for module in pkgutil.iter_modules(path):
        importlib.import_module(f"{package}.{module.name}")
