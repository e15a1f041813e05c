"""Who sends a request, and what their key allows."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import Depends, Request

from modallab.store.base import ForbiddenError, UnauthorisedError
from modallab.store.keys import Key, Role
from modallab.store.viewer import EVERYONE, NOBODY, Viewer


@dataclass(frozen=True)
class Caller:
    """Whoever sends a request."""

    viewer: Viewer
    key: Key | None = None
    """The key that was sent; None: the service has no keys, or the address needs none."""


WITHOUT_KEYS = Caller(EVERYONE)
_UNKNOWN = Caller(NOBODY)


async def _caller(request: Request) -> Caller:
    # `modallab.api.gate` lets nobody pass unnamed but to addresses that are open to all.
    caller: Caller = getattr(request.state, "caller", _UNKNOWN)
    return caller


CallerDep = Annotated[Caller, Depends(_caller)]
Verify = Callable[[], Awaitable[object]]


async def _verify(request: Request) -> Verify:
    """Return what raises `UnauthorisedError` once the key, or the session, of a request has ended."""
    verify: Verify = request.state.verify
    return verify


VerifyDep = Annotated[Verify, Depends(_verify)]


async def _person(caller: CallerDep) -> None:
    _check(caller, (Role.ADMIN, Role.INSTRUCTOR, Role.STUDENT))


async def _teacher(caller: CallerDep) -> None:
    _check(caller, (Role.ADMIN, Role.INSTRUCTOR))


async def _operator(caller: CallerDep) -> None:
    _check(caller, (Role.ADMIN, Role.SERVICE))


def _check(caller: Caller, roles: tuple[Role, ...]) -> None:
    """Raise unless the caller has one of the roles; without keys everybody has all of them."""
    if caller is _UNKNOWN:
        raise UnauthorisedError("a key is needed")
    if caller.key is not None and caller.key.role not in roles:
        allowed = [role.value for role in roles]
        raise ForbiddenError(f"this is not for the role {caller.key.role.value}", allowed=allowed)


PERSONS: Any = Depends(_person)
OPERATORS: Any = Depends(_operator)
TEACHERS: Any = Depends(_teacher)


async def _key(caller: CallerDep) -> Key:
    if caller.key is None:
        raise ForbiddenError(
            "this service has no keys yet; on its machine `modallab keys create --role admin --name NAME` "
            "makes the first"
        )
    return caller.key


KeyDep = Annotated[Key, Depends(_key)]


async def _teacher_key(caller: CallerDep, key: KeyDep) -> Key:
    _check(caller, (Role.ADMIN, Role.INSTRUCTOR))
    return key


async def _admin_key(caller: CallerDep, key: KeyDep) -> Key:
    _check(caller, (Role.ADMIN,))
    return key


TeacherKeyDep = Annotated[Key, Depends(_teacher_key)]
ANY_KEY: Any = Depends(_key)
ADMIN_KEY: Any = Depends(_admin_key)
