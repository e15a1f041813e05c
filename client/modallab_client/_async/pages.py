"""Lists that the service sends in pages."""

from typing import Any, Protocol, TypeVar

from modallab_client import _wire
from modallab_client._async.transport import AsyncTransport

T_co = TypeVar("T_co", covariant=True)


class PageOf(Protocol[T_co]):
    """Part of a list."""

    @property
    def items(self) -> tuple[T_co, ...]:
        """Entries of this part."""
        ...

    @property
    def next(self) -> str | None:
        """Value of `after` for the next page; None at the end."""
        ...


async def all_items(
    transport: AsyncTransport, path: str, page: type[PageOf[T_co]], **wanted: Any
) -> tuple[T_co, ...]:
    """Return the entries of all pages of a list, in the service's order.

    Parameters
    ----------
    page
        Type of a reply.
    wanted
        Of the query; None: anything.
    """
    items: tuple[T_co, ...] = ()
    cursor: str | None = None
    while True:
        params = _wire.body(after=cursor, **wanted)
        reply = _wire.reply(page, await transport.request("GET", path, params=params))
        items += reply.items
        cursor = reply.next
        if cursor is None:
            return items
