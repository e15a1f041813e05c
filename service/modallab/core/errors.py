"""Errors that the numerics raise deliberately."""


class ModalLabError(Exception):
    """Base of every error raised on purpose: a stable code, a sentence, plain values.

    Errors know nothing of HTTP; `api.problems` gives each class its status. `context` names the
    `field`, the `value` and what is `allowed` wherever one input is to blame.
    """

    code = "modallab"

    def __init__(self, message: str, **context: str | float) -> None:
        super().__init__(message)
        self.context = context


class InvalidInputError(ModalLabError, ValueError):
    """Invalid input: wrong shape, value out of bounds, unknown name."""

    code = "invalid_input"


class UnknownDofError(InvalidInputError):
    """A degree of freedom that the structure does not have."""

    code = "unknown_dof"


class StructureError(InvalidInputError):
    """A structure that cannot be analysed: disconnected, fully constrained, of negative section."""

    code = "structure"


class NotFoundError(ModalLabError, LookupError):
    """Nothing is stored under that id."""

    code = "not_found"


class NoModeInBandError(ModalLabError):
    """The band handed to an extraction method holds no resonance."""

    code = "no_mode_in_band"


class UnderdeterminedError(ModalLabError):
    """Fewer equations than unknowns, or modes that pair with nothing."""

    code = "underdetermined"


class DivergedError(ModalLabError):
    """An iteration left the region where its equations hold."""

    code = "diverged"


class MissingExtraError(ModalLabError):
    """The request needs an optional dependency that is not installed."""

    code = "missing_extra"


class CancelledError(ModalLabError):
    """The caller asked for the work to stop."""

    code = "cancelled"
