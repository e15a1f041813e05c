"""Families: named sets of interchangeable parts, one file a part."""

import importlib
import inspect
import pkgutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TypeVar

from modallab.core.errors import InvalidInputError

T = TypeVar("T")


class Family(Mapping[str, T]):
    """A named set of interchangeable parts, read like a dict; each file adds one.

    The members' folder is imported when the family is first read, so that a family is
    complete for every caller, and a lower layer need not import the folder of the members.
    """

    def __init__(self, name: str, home: str) -> None:
        self.name = name
        self._home = home
        self._members: dict[str, T] = {}
        self._whole = False

    def _known(self) -> dict[str, T]:
        if not self._whole:
            importlib.import_module(self._home)
            self._whole = True
        return self._members

    def register(self, kind: str) -> Callable[[T], T]:
        """Return a decorator that adds its target under `kind`."""

        def add(member: T) -> T:
            if kind in self._members:
                raise RuntimeError(f"{self.name} {kind!r} is registered twice")
            self._members[kind] = member
            return member

        return add

    def __getitem__(self, kind: str) -> T:
        return member(self._known(), kind, self.name, field=self.name)

    def __contains__(self, kind: object) -> bool:
        return kind in self._known()

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._known()))

    def __len__(self) -> int:
        return len(self._known())


def member(members: Mapping[str, T], name: str, noun: str, *, field: str) -> T:
    """Return the member of a family that has a certain name.

    Parameters
    ----------
    members
        All members by name.
    noun
        Noun for a member in the error.
    field
        Field of the request that names it.

    Raises
    ------
    InvalidInputError
        If there is no such member.
    """
    if name not in members:
        raise InvalidInputError(
            f"no {noun} called {name!r}", field=field, value=name, allowed=sorted(members)
        )
    return members[name]


def first_line(documented: object) -> str:
    """Return the first line of a docstring; empty where there is none."""
    return (inspect.getdoc(documented) or "").split("\n")[0]


def discover(package: str, path: Iterable[str]) -> None:
    """Import every module of a package, so that its members register themselves."""
    for module in pkgutil.iter_modules(path):
        importlib.import_module(f"{package}.{module.name}")
