"""Modes that a request drops from a modal model, and those that it merges into one."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from modallab.core.errors import InvalidInputError, bounds


@dataclass(frozen=True)
class ModeSelection:
    """Modes of a modal model, counted from 1, to be dropped or merged.

    Raises
    ------
    InvalidInputError
        If nothing is asked for, a mode is named twice, or a group to be merged has one mode.
    """

    drop: tuple[int, ...] = ()
    """Modes to be dropped."""
    merge: tuple[tuple[int, ...], ...] = ()
    """Groups of modes, each to become one."""

    def __post_init__(self) -> None:
        if not self.drop and not self.merge:
            raise InvalidInputError(
                "no mode is dropped or merged", field="drop", value=[], allowed="numbers of modes, from 1"
            )
        for group in self.merge:
            if len(set(group)) < 2:
                raise InvalidInputError(
                    "at least two modes are merged", field="merge", value=list(group), allowed=bounds(2)
                )
        for number, count in Counter(number for _, number in self._named()).items():
            if count > 1:
                raise InvalidInputError(
                    f"mode {number} is named {count} times", field="merge", value=number, allowed="once"
                )

    def groups(self, n_modes: int) -> list[tuple[int, ...]]:
        """Return the modes that become each mode of the new model, as indices from 0.

        Parameters
        ----------
        n_modes
            Number of modes of the model.

        Raises
        ------
        InvalidInputError
            If the model lacks a mode, or no mode is left.
        """
        for field, number in self._named():
            if not 1 <= number <= n_modes:
                raise InvalidInputError(
                    f"there is no mode {number}", field=field, value=number, allowed=bounds(1, n_modes)
                )
        if len(self.drop) == n_modes:
            raise InvalidInputError(
                "no mode is left", field="drop", value=list(self.drop), allowed=f"fewer than {n_modes} modes"
            )
        merged = {number for group in self.merge for number in group}
        single = [(n - 1,) for n in range(1, n_modes + 1) if n not in merged and n not in self.drop]
        return sorted([*single, *(tuple(sorted(n - 1 for n in group)) for group in self.merge)])

    @property
    def words(self) -> str:
        """The request in words."""
        dropped = [f"dropped {', '.join(map(str, sorted(self.drop)))}"] if self.drop else []
        merged = [f"merged {' and '.join(map(str, sorted(group)))}" for group in self.merge]
        return "; ".join([*dropped, *merged])

    def _named(self) -> Iterator[tuple[str, int]]:
        for number in self.drop:
            yield "drop", number
        for group in self.merge:
            for number in group:
                yield "merge", number
