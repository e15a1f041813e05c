"""What is known of a test beside its files: averages, exciter, window."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from modallab.core.assumption import Assumption
from modallab.core.errors import InvalidInputError, bounds
from modallab.estimation.windows import WINDOWS
from modallab.interchange.settings import READING
from modallab.rig.analyser import Analyser
from modallab.rig.setup import RigSetup

ExciterKind = Literal["shaker", "hammer"]


@dataclass(frozen=True)
class DeclaredTest:
    """What is known of a test beside its files; None: not declared."""

    averages: float | None = None
    """1, effective number of averages; by default the file's, or else the rig's."""
    exciter: ExciterKind | None = None
    """`shaker` or `hammer`, of a test without a log book."""
    window: str | None = None
    """Window of a test without a log book."""

    def __post_init__(self) -> None:
        if self.averages is not None and not 1 <= self.averages <= READING.max_stated_averages:
            raise InvalidInputError(
                "averages is out of bounds",
                field="averages",
                value=self.averages,
                allowed=bounds(1, READING.max_stated_averages),
            )
        for name, value, allowed in (
            ("exciter", self.exciter, ["shaker", "hammer"]),
            ("window", self.window, list(WINDOWS)),
        ):
            if value is not None and value not in allowed:
                raise InvalidInputError(
                    f"there is no {name} {str(value)!r}", field=name, value=value, allowed=allowed
                )

    def check_against(self, setup: RigSetup) -> None:
        """Raise unless the log book agrees with what is declared beside it."""
        for name, value, known in (
            ("exciter", self.exciter, setup.exciter.kind),
            ("window", self.window, setup.analyser.window),
        ):
            if value not in (None, known):
                raise InvalidInputError(
                    f"the rig declares another {name}", field=name, value=value, allowed=[known]
                )

    def known_averages(self, in_file: float | None, in_rig: float | None) -> float | None:
        """Return the averages: as declared, or else as in the file, or else as in the rig."""
        return next((float(n) for n in (self.averages, in_file, in_rig) if n is not None), None)

    def assumptions(self, exciter: str) -> Iterator[Assumption]:
        """Yield what is assumed of a test without a log book."""
        if self.exciter is None:
            yield Assumption("exciter", exciter, "`exciter` is not declared")
        if self.window is None:
            yield Assumption("window", Analyser.window, "`window` is not declared")
        elif WINDOWS[self.window].end < 1:
            reason = "height of the exponential window at its end; a rig declares it as `window_end`"
            yield Assumption("window_end", f"{Analyser.window_end:g}", reason)


NOTHING_DECLARED = DeclaredTest()
