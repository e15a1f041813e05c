"""Stored things named by their ids, or by the results that have them."""

from typing import Protocol, overload


class HasId(Protocol):
    """A stored result."""

    @property
    def id(self) -> str:
        """Id of the stored thing."""
        ...


Identified = str | HasId
"""A stored thing: its id, or a result that was returned for it."""


@overload
def id_of(thing: Identified) -> str: ...
@overload
def id_of(thing: Identified | None) -> str | None: ...
def id_of(thing: Identified | None) -> str | None:
    """Return the id of a stored thing; None of None.

    Raises
    ------
    TypeError
        If it is neither an id nor a result.
    """
    if thing is None or isinstance(thing, str):
        return thing
    name = getattr(thing, "id", None)
    if not isinstance(name, str):
        raise TypeError(f"an id or a result is needed, not {type(thing).__name__}")
    return name
