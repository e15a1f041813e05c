"""Exceptions of the client, one class for each kind of problem that the service names.

Catch `ClientError` for all of them. `code` is stable and meant for programs, `detail` for people;
`context` names the field, its value and what is allowed wherever one input is to blame.
"""

from collections.abc import Mapping
from typing import Any


class ClientError(Exception):
    """Base of every error of this package, and the class of problems it has no name for."""

    code = "error"

    def __init__(
        self,
        detail: str,
        *,
        code: str | None = None,
        context: Mapping[str, Any] | None = None,
        status: int | None = None,
    ) -> None:
        super().__init__(detail)
        self.detail = detail
        self.code = code if code is not None else type(self).code
        self.context = dict(context or {})
        self.status = status

    def __str__(self) -> str:
        # The service's own sentence names field, value and values allowed already.
        short = {name: value for name, value in self.context.items() if isinstance(value, (str, float, int))}
        details = ", ".join(
            f"{name}={value!r}" for name, value in short.items() if str(value) not in self.detail
        )
        return f"{self.detail} ({details})" if details else self.detail


class InvalidInputError(ClientError, ValueError):
    """Invalid input: wrong shape, out of bounds, unknown name."""

    code = "invalid_input"


class UnknownDofError(InvalidInputError):
    """A degree of freedom that the structure does not have."""

    code = "unknown_dof"


class StructureError(InvalidInputError):
    """A structure that cannot be analysed: disconnected, wholly held, of negative section."""

    code = "structure"


class NotFoundError(ClientError, LookupError):
    """Nothing is stored under that id."""

    code = "not_found"


class NoModeInBandError(ClientError):
    """The band handed to an extraction method holds no resonance."""

    code = "no_mode_in_band"


class UnderdeterminedError(ClientError):
    """Fewer equations than unknowns, or modes that pair with nothing."""

    code = "underdetermined"


class DivergedError(ClientError):
    """An iteration left the region where its equations hold."""

    code = "diverged"


class CancelledError(ClientError):
    """The work was asked to stop."""

    code = "cancelled"


class ConflictError(ClientError):
    """The request does not fit the present state, such as cancelling finished work."""

    code = "conflict"


class TooLargeError(ClientError):
    """More was sent, or asked for, than the service handles at once."""

    code = "too_large"


class BusyError(ClientError):
    """The service's queue is full, for all or for this key, and stayed full while the client waited."""

    code = "busy"


class QuotaError(ClientError):
    """As much is stored for the key, or for its class, as may be."""

    code = "storage_quota"


class UnauthorisedError(ClientError):
    """The service wants an API key, or does not know the one it was given."""

    code = "unauthorized"  # as HTTP spells it


class ForbiddenError(ClientError):
    """The API key does not allow this."""

    code = "forbidden"


class UnreachableError(ClientError, ConnectionError):
    """No reply: no service at that address, or the connection broke."""

    code = "unreachable"


class UnexpectedReplyError(ClientError):
    """A reply that this client cannot read: another version, or not a modallab service."""

    code = "unexpected_reply"


class JobFailedError(ClientError):
    """Work on the service failed or was cancelled; code, detail and context are the service's own."""

    code = "job_failed"


class JobTimeoutError(ClientError, TimeoutError):
    """The time allowed for waiting is over; the work goes on."""

    code = "job_timeout"


class ServiceStartError(ClientError):
    """The embedded service did not start; the end of its log is in the message."""

    code = "service_start"


class MissingExtraError(ClientError, ImportError):
    """Optional packages are not installed; the message holds the command that does it."""

    code = "missing_extra"


class PlausibilityWarning(UserWarning):
    """What was sent is surely a slip of a unit or a setting, although the service can compute with it."""


BY_CODE: dict[str, type[ClientError]] = {
    "invalid_input": InvalidInputError,
    "invalid_request": InvalidInputError,
    "unknown_dof": UnknownDofError,
    "structure": StructureError,
    "not_found": NotFoundError,
    "no_mode_in_band": NoModeInBandError,
    "underdetermined": UnderdeterminedError,
    "diverged": DivergedError,
    "cancelled": CancelledError,
    "conflict": ConflictError,
    "in_trash": ConflictError,
    "in_use": ConflictError,
    "key_reused": ConflictError,
    "too_large": TooLargeError,
    "content_too_large": TooLargeError,
    "too_costly": TooLargeError,
    "busy": BusyError,
    "queue_full": BusyError,
    "queue_quota": BusyError,
    "storage_quota": QuotaError,
    "service_unavailable": BusyError,
    "unauthorized": UnauthorisedError,
    "forbidden": ForbiddenError,
}
