"""What is known of a test beside its files: averages, exciter, window and its end."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from modallab.core.assumption import Assumption
from modallab.core.errors import InvalidInputError, bounds
from modallab.estimation.error_correlation import ErrorCorrelation
from modallab.estimation.windows import WINDOWS
from modallab.interchange.settings import READING
from modallab.rig.analyser import Analyser
from modallab.rig.excitation import ExcitationSetting
from modallab.rig.hardware import within
from modallab.rig.settings import ACQUISITION
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
    window_end: float | None = None
    """1, height of an exponential window at the end of the record, of a test without a log book."""

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
        if self.window_end is not None:
            within("window_end", self.window_end, *ACQUISITION.window_end_bounds)

    @property
    def analyser_window(self) -> dict[str, Any]:
        """Window and height of its end, as an analyser has them, of a test without a log book.

        Raises
        ------
        InvalidInputError
            If a height is declared of a window that does not decay.
        """
        window = self.window or Analyser.window
        if self.window_end is None:
            return {"window": window}
        _check_decaying(window)
        return {"window": window, "window_end": self.window_end}

    def check_against(self, setup: RigSetup) -> None:
        """Raise unless the log book agrees with what is declared beside it."""
        if self.window_end is not None:
            _check_decaying(setup.analyser.window)
        for name, value, known in (
            ("exciter", self.exciter, setup.exciter.kind),
            ("window", self.window, setup.analyser.window),
            ("window_end", self.window_end, setup.analyser.window_end),
        ):
            if value not in (None, known):
                raise InvalidInputError(
                    f"the rig declares another {name}", field=name, value=value, allowed=[known]
                )

    def known_averages(self, in_file: float | None, in_rig: float | None) -> float | None:
        """Return the averages: as declared, or else as in the file, or else as in the rig."""
        return next((float(n) for n in (self.averages, in_file, in_rig) if n is not None), None)

    def assumptions(self, exciter: str, correlation: ErrorCorrelation | None) -> Iterator[Assumption]:
        """Yield what is assumed of a test without a log book.

        Parameters
        ----------
        exciter
            Kind of exciter.
        correlation
            Correlation of the errors of neighbouring lines; None: unknown.
        """
        if self.exciter is None:
            yield Assumption("exciter", exciter, "`exciter` is not declared")
        if self.window is None:
            shown = "" if correlation is None else _shown(correlation)
            yield Assumption("window", Analyser.window, f"`window` is not declared{shown}")
        elif self.window_end is None and WINDOWS[self.window].end < 1:
            reason = "height of the exponential window at its end; `window_end` is not declared"
            yield Assumption("window_end", f"{Analyser.window_end:g}", reason)
        reason = "records without leakage; a rig declares another source as `analyser.excitation`"
        yield Assumption("excitation", ExcitationSetting.kind, reason)


def _check_decaying(window: str) -> None:
    """Raise `InvalidInputError` if a window is not exponential."""
    if WINDOWS[window].end == 1:
        raise InvalidInputError(
            f"the window is {window}, which does not decay: only an exponential one has a `window_end`",
            field="window_end",
            value=window,
            allowed=[name for name, known in WINDOWS.items() if known.end < 1],
        )


def _shown(correlation: ErrorCorrelation) -> str:
    """Return the window that errors of neighbouring lines show, as text; empty for a rectangular one."""
    if correlation.exponential:
        return (
            "; errors of neighbouring lines are correlated as by an exponential window that falls to "
            f"{correlation.window.end:.2g} at its end, which adds damping to every mode"
        )
    name = next(name for name, window in WINDOWS.items() if window == correlation.window)
    return "" if name == Analyser.window else f"; errors of neighbouring lines are correlated as by `{name}`"


NOTHING_DECLARED = DeclaredTest()
