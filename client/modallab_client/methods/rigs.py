"""Rigs: what is declared, in a sentence and a table."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from modallab_client import _tables

if TYPE_CHECKING:
    from modallab_client._generated.models import Analyser, Exciter, PhysicsWarning


class RigMethods:
    """A sentence and a table on a rig."""

    compared: ClassVar[bool] = True
    if TYPE_CHECKING:
        id: str
        drives: tuple[str, ...]
        responses: tuple[str, ...]
        exciter: Exciter
        analyser: Analyser
        warnings: Sequence[PhysicsWarning]

    def summary(self) -> str:
        """Return exciter, responses, lines and averages in one sentence."""
        return ", ".join(f"{value} {name}".strip() for name, value in self._facts())

    def _facts(self) -> list[tuple[str, str]]:
        analyser = self.analyser
        averages = "unknown" if analyser.averages is None else str(analyser.averages)
        lines = f"{analyser.n_lines} lines from {analyser.frequency_min:g} to {analyser.frequency_max:g} Hz"
        return [
            ("", f"{self.exciter.kind} at {', '.join(self.drives)}"),
            ("responses", str(len(self.responses))),
            ("", lines),
            ("averages", averages),
        ]

    def _repr_html_(self) -> str:
        exciter, responses, lines, averages = (value for _, value in self._facts())
        rows = [
            ("exciter", exciter),
            ("responses", f"{responses}: {', '.join(self.responses)}"),
            ("analyser", lines),
            ("excitation, window, estimator", self._settings()),
            ("averages", averages),
            *(("warning", f"{warning.field}: {warning.message}") for warning in self.warnings),
        ]
        return _tables.html((), rows, caption=f"Rig {self.id}")

    def _settings(self) -> str:
        analyser = self.analyser
        names = (analyser.excitation.kind, analyser.window, analyser.estimator)
        return ", ".join(name.replace("_", " ") for name in names)
