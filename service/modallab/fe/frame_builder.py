"""Plane frames of the 1992 thesis: aluminium bars in bays of 5 m by 3 m, appendix B.3."""

from collections.abc import Sequence
from itertools import pairwise

from modallab.fe.structure import Material, Member, Section, Structure
from modallab.fe.structure_settings import ELEMENT

Point = tuple[float, float]

ALLOY = Material(modulus=7.5e10, density=2800.0, name="aluminium")
HORIZONTAL = Section(area=4e-3, second_moment=7.56e-2, name="horizontal")
VERTICAL = Section(area=6e-3, second_moment=7.56e-2, name="vertical")
DIAGONAL = Section(area=3e-3, second_moment=7.56e-2, name="diagonal")


def _bars(start: Point, end: Point) -> tuple[int, Section]:
    across, up = abs(end[0] - start[0]), abs(end[1] - start[1])
    if across == 0:
        return round(up * ELEMENT.vertical_elements_per_metre), VERTICAL
    return round(across * ELEMENT.elements_per_metre), HORIZONTAL if up == 0 else DIAGONAL


def frame_along(path: Sequence[Point], *, name: str) -> Structure:
    """Return the free, undamped frame whose bars follow a path of straight lines.

    Members are numbered along the path, and nodes where it first meets them.

    Parameters
    ----------
    path
        Corners, m.
    """
    numbers: dict[Point, int] = {}
    members: list[Member] = []

    def node(x: float, y: float) -> int:
        return numbers.setdefault((round(x, 9), round(y, 9)), len(numbers) + 1)

    for start, end in pairwise(path):
        n, section = _bars(start, end)
        run = [
            node(start[0] + (end[0] - start[0]) * i / n, start[1] + (end[1] - start[1]) * i / n)
            for i in range(n + 1)
        ]
        for ends in pairwise(run):
            members.append(Member(len(members) + 1, ends, section, ALLOY))
    return Structure(nodes={k: place for place, k in numbers.items()}, members=tuple(members), name=name)
