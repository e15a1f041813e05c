"""Work that waits where the database is away for a while."""

import errno
from collections.abc import Callable
from typing import Any, TypeVar

import structlog
from sqlalchemy.exc import DBAPIError, InterfaceError, OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeout
from tenacity import RetryCallState, Retrying, retry_if_exception, stop_after_delay, wait_random_exponential

from modallab.jobs.settings import JOB

Outcome = TypeVar("Outcome")
_log = structlog.get_logger()


# SQLite has one class for these and for a wrong question, as of a table that there is not.
_OF_SQLITE = ("locked", "full", "disk i/o", "unable to open", "readonly")
_OF_DISKS = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)


def is_outage(error: BaseException) -> bool:
    """Return whether an error says that database or disk are away, busy or full, and not a wrong question."""
    if isinstance(error, OSError):
        return error.errno in _OF_DISKS
    if isinstance(error, PoolTimeout):
        return True
    if not isinstance(error, DBAPIError):
        return False
    if error.connection_invalidated or isinstance(error, InterfaceError):
        return True
    if not isinstance(error, OperationalError):
        return False
    of_sqlite = "sqlite" in type(error.orig).__module__
    return not of_sqlite or any(words in str(error.orig).lower() for words in _OF_SQLITE)


def patiently(work: Callable[..., Outcome], *arguments: Any) -> Outcome:
    """Return the result of work that may be repeated, tried anew while the database is away.

    Raises
    ------
    DBAPIError
        If it stays away for longer than an outage is waited for.
    """
    return Retrying(
        retry=retry_if_exception(is_outage),
        wait=wait_random_exponential(multiplier=JOB.outage_pause, max=JOB.longest_outage_pause),
        stop=stop_after_delay(JOB.longest_outage),
        before_sleep=_say,
        reraise=True,
    )(work, *arguments)


def _say(state: RetryCallState) -> None:
    # Once, not at every try: the log is read when something is wrong already.
    if state.attempt_number == 1 and state.outcome is not None:
        _log.warning("the database is away", error=str(state.outcome.exception()).splitlines()[0])
