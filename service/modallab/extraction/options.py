"""Options common to extraction methods; a method with further ones declares them beside itself."""

from dataclasses import dataclass
from enum import StrEnum

from modallab.core.errors import InvalidInputError, bounds
from modallab.core.options import Options, option

MIN_LINES = 4  # three complex unknowns and one line over, so that a misfit can show
MOST_ORDER = 200


class Damping(StrEnum):
    """Law of a mode's damping near its resonance."""

    STRUCTURAL = "structural"
    VISCOUS = "viscous"


@dataclass(frozen=True)
class ExtractionOptions(Options):
    """Options of every extraction method; None leaves the choice to the method, which states it."""

    damping: Damping | None = option(None, doc="law of a mode's damping")

    @property
    def assumed_damping(self) -> Damping:
        """The law of damping of the fits: structural where none is asked for."""
        return self.damping or Damping.STRUCTURAL


@dataclass(frozen=True)
class SingleModeOptions(ExtractionOptions):
    """Options of every single-mode method."""

    lines: int | None = option(
        None, unit="1", lower=MIN_LINES, doc="frequency lines around each resonance that a fit draws on"
    )


@dataclass(frozen=True)
class DistantLinesOptions(SingleModeOptions):
    """Options of a single-mode method that can do without the lines nearest resonance."""

    leave_out: int | None = option(
        None, unit="1", lower=0, doc="number of these lines, nearest resonance, that are not used"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lines is not None and self.lines - (self.leave_out or 0) < MIN_LINES:
            raise InvalidInputError(
                "too few lines are left",
                field="leave_out",
                value=self.leave_out or 0,
                allowed=bounds(maximum=self.lines - MIN_LINES),
            )


@dataclass(frozen=True)
class GlobalOptions(ExtractionOptions):
    """Options of a global method."""

    max_order: int | None = option(
        None, unit="1", lower=2, upper=MOST_ORDER, doc="highest model order of the stabilisation chart"
    )
