"""What a student may choose of a test: fields of the rig, and their limits."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from modallab.core.errors import InvalidInputError, bounds

Scalar = bool | int | float | str


@dataclass(frozen=True)
class Choice:
    """Limits of one field: an interval or a list."""

    lower: float | None = None
    """Smallest number; None: no number is an interval's."""
    upper: float | None = None
    """Largest number."""
    values: tuple[Scalar, ...] = ()
    """Values allowed; of a field that is a list, each of its entries."""

    def check(self, field: str, value: Any) -> None:
        """Raise `InvalidInputError` unless a value, or each entry of a list, is within the limits."""
        for entry in value if isinstance(value, list) else [value]:
            if not self._allows(entry):
                allowed: Any = list(self.values) if self.lower is None else bounds(self.lower, self.upper)
                raise InvalidInputError(
                    "the assignment allows other values", field=field, value=value, allowed=allowed
                )

    def _allows(self, entry: Any) -> bool:
        if self.lower is None or self.upper is None:
            # `True == 1`, and one of them may be allowed alone
            return any(
                entry == value and isinstance(entry, bool) == isinstance(value, bool) for value in self.values
            )
        is_number = isinstance(entry, (int, float)) and not isinstance(entry, bool)
        return is_number and self.lower <= entry <= self.upper


def chosen_rig(
    frame: Mapping[str, Any], choices: Mapping[str, Choice], chosen: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the body of a rig: the frame with a student's choices.

    Parameters
    ----------
    frame
        Body of the rig that the instructor gave.
    choices
        Limits by field, written with dots: `analyser.averages`.
    chosen
        Part of a rig's body: the fields that the student sets.

    Raises
    ------
    InvalidInputError
        If a field is not the student's to choose, or its value is out of the limits.
    """
    rig = _copied(frame)
    for path, value in _leaves(chosen, choices):
        if path not in choices:
            raise InvalidInputError(
                "the assignment fixes this field", field=path, value=value, allowed=sorted(choices)
            )
        choices[path].check(path, value)
        _put(rig, path, value)
    return rig


def _copied(tree: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _copied(value) if isinstance(value, Mapping) else value for name, value in tree.items()}


def _leaves(
    tree: Mapping[str, Any], choices: Mapping[str, Choice], before: str = ""
) -> Iterator[tuple[str, Any]]:
    for name, value in tree.items():
        path = f"{before}{name}"
        if isinstance(value, Mapping) and path not in choices:
            yield from _leaves(value, choices, f"{path}.")
        else:
            yield path, value


def _put(rig: dict[str, Any], path: str, value: Any) -> None:
    *parts, last = path.split(".")
    for part in parts:
        inner = rig.get(part)
        rig[part] = inner if isinstance(inner, dict) else {}
        rig = rig[part]
    rig[last] = value
