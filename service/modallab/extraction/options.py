"""How an extraction goes about it."""

from dataclasses import dataclass
from enum import StrEnum

from modallab.core.errors import InvalidInputError

MIN_LINES = 4  # three complex unknowns and one line over, so that a misfit can show
MOST_ORDER = 200


class Damping(StrEnum):
    """What law the damping of a mode follows near its resonance."""

    STRUCTURAL = "structural"
    VISCOUS = "viscous"


@dataclass(frozen=True)
class ExtractionOptions:
    """What the user decides; what is None is chosen from the data, and the modal model says how and why.

    Raises
    ------
    InvalidInputError
        If a number has no meaning.
    """

    lines: int | None = None  # around each resonance; of single-mode methods
    leave_out: int | None = None  # of these, the nearest to resonance; of single-mode methods
    damping: Damping | None = None
    max_order: int | None = None  # of the stabilisation chart; of global methods

    @property
    def law(self) -> Damping:
        """The law of damping to fit by: structural where none is asked for."""
        return self.damping or Damping.STRUCTURAL

    def __post_init__(self) -> None:
        bounds = {"lines": (MIN_LINES, None), "leave_out": (0, None), "max_order": (2, MOST_ORDER)}
        for name, (lower, upper) in bounds.items():
            value = getattr(self, name)
            if value is not None and not (lower <= value and (upper is None or value <= upper)):
                allowed = f"{lower} or more" if upper is None else f"{lower} to {upper}"
                raise InvalidInputError(f"{name} is out of bounds", field=name, value=value, allowed=allowed)
        if self.lines is not None and self.lines - (self.leave_out or 0) < MIN_LINES:
            raise InvalidInputError(
                "too few lines are left",
                field="leave_out",
                value=self.leave_out or 0,
                allowed=f"{self.lines - MIN_LINES} or fewer of {self.lines} lines",
            )
