"""What a picture of an effect shows: a structure, a rig, the effect in it, and the curves to look at."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from modallab.fe.beam import beam
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Material, Member, Section, Structure, Support

Wire = Mapping[str, Any]  # a body, or a part of one, as the service takes it

STEEL = Material(modulus=2.09e11, density=7800.0)
BAR = Section(area=5e-4, second_moment=4.1667e-9)
LAW = StructuralDamping(stiffness_coefficient=0.005)
DAMPED = StructuralDamping(stiffness_coefficient=0.05)


@dataclass(frozen=True)
class Example:
    """One picture; parts left out are the plainest.

    `panels` name a quantity each, `magnitude`, `phase`, `coherence`, `force`, `response`, `ratio` or `turn`,
    of the last response or of the one named behind it; without any, those that show something are drawn.
    """

    structure: str = "free beam"
    rig: Wire = field(default_factory=dict)  # over drive 1:+Y, response 7:+Y
    at: Any = None  # of the effect, as in a request
    parameters: Wire = field(default_factory=dict)  # where the default shows nothing
    declared: Wire | None = None  # hardware that implies the effect, instead of the effect
    band: tuple[float, float] = (0.0, 800.0)  # Hz, drawn
    panels: tuple[str, ...] = ()
    levels: tuple[float, ...] = ()  # N, where the level matters
    shows: str = ""  # one sentence under the picture


@lru_cache(maxsize=8)
def structure(name: str) -> Structure:
    """Return one of the structures that effects are shown on."""
    return _HEADER[name]()


def _beam(
    length: float = 1.5, supports: tuple[Support, ...] = (), damping: StructuralDamping = LAW
) -> Structure:
    return beam(length=length, n_elements=20, section=BAR, material=STEEL, damping=damping, supports=supports)


def _frame() -> Structure:
    """Return two legs of the beam's bar at a right angle, clamped at the foot: X and Y move together."""
    nodes = {i + 1: (0.0, 0.1 * i) for i in range(8)} | {i + 1: (0.1 * (i - 7), 0.7) for i in range(8, 13)}
    members = tuple(Member(i, (i, i + 1), BAR, STEEL) for i in range(1, 13))
    return Structure(
        nodes=nodes, members=members, supports=(Support(1, ("X", "Y", "RZ")),), damping=LAW, name="frame"
    )


_HEADER = {
    "free beam": _beam,
    "clamped beam": lambda: _beam(supports=(Support(1, ("Y", "RZ")),)),
    "damped beam": lambda: _beam(supports=(Support(1, ("Y", "RZ")),), damping=DAMPED),
    "short beam": lambda: _beam(0.3),
    "frame": _frame,
}
DESCRIBED = {
    "free beam": "a free steel beam, 1.5 m of 50 mm by 10 mm in 20 members, 5.85 kg",
    "clamped beam": "a steel beam, 1.5 m of 50 mm by 10 mm in 20 members, clamped at node 1",
    "damped beam": "a steel beam, 1.5 m of 50 mm by 10 mm in 20 members, clamped at node 1, loss factor 0.05",
    "short beam": "a free steel beam, 0.3 m of 50 mm by 10 mm in 20 members, 1.17 kg",
    "frame": "a steel frame of 50 mm by 10 mm, clamped at node 1: 0.7 m up to node 8, 0.5 m across to 13",
}
