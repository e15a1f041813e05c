"""Further tests that a laboratory could do, from cheap to dear, and what each is good for."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.dof import Dof
from modallab.fe.system import DynamicSystem
from modallab.rig.change import AddedMass, Change
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.setup import RigSetup

LOUDER = 3.0
LONGER = 10.0
KNOWN_MASS = 0.05  # kg: felt by a beam of some kilograms, and at hand in every laboratory
DRIVES = 3  # other drive points that are considered


@dataclass(frozen=True)
class FurtherTest:
    """A change against the first test, and what it shows, in words."""

    change: Change
    why: str


def further_tests(setup: RigSetup, system: DynamicSystem) -> Iterator[FurtherTest]:
    """Return the tests that are considered, the cheapest first."""
    yield from _at_the_analyser(setup)
    for drive in _spread([d.point for d in setup.responses if d.point != setup.drive.point], DRIVES):
        yield FurtherTest(
            Change(drive=drive),
            f"with the force at {drive} what hangs on the shaker or the gauge acts there; what belongs to "
            "the structure stays where it is",
        )
    if setup.exciter.kind == "shaker":
        yield FurtherTest(
            Change(exciter="hammer"),
            "a hammer leaves nothing on the structure: what the shaker, its stinger or the gauge did is gone",
        )
    if others := _others(setup, system):
        yield FurtherTest(
            Change(responses=others),
            "other places see other parts of the mode shapes, and a fault of one channel is not seen there",
        )
    for at, words in ((None, "on the accelerometer"), (setup.drive.point, "at the drive point")):
        yield FurtherTest(
            Change(added_mass=AddedMass(KNOWN_MASS, at)),
            f"a known mass {words} moves every mode by an amount that scales a wrong mass, a wrong stiffness "
            "and a wrong sensitivity in different ways",
        )


def _at_the_analyser(setup: RigSetup) -> Iterator[FurtherTest]:
    """Return what takes no more than other settings."""
    analyser = setup.analyser
    yield FurtherTest(
        Change(level_factor=LOUDER),
        "at three times the level a linear effect is the same and a nonlinear one is not",
    )
    yield FurtherTest(
        Change(averages_factor=LONGER),
        "ten times the averages make every random error three times smaller",
    )
    yield FurtherTest(
        Change(n_lines=2 * analyser.n_lines - 1),
        "lines twice as fine show the width of a resonance, leak less, and lie elsewhere",
    )
    if EXCITATIONS[analyser.excitation.kind].continuous > 0:
        yield FurtherTest(
            Change(excitation="periodic_random", window="rectangular"),
            "an excitation that repeats with the record does not leak: damping is seen as it is",
        )
    yield FurtherTest(
        Change(frequency_max=2 * analyser.frequency_max, n_lines=2 * analyser.n_lines - 1),
        "twice the band shows modes that two explanations need not share",
    )


def _spread(dofs: list[Dof], count: int) -> list[Dof]:
    """Return some of the DoFs, evenly from all of them."""
    chosen = np.linspace(0, len(dofs) - 1, min(count, len(dofs))).round().astype(int)
    return [dofs[i] for i in dict.fromkeys(chosen.tolist())]


def _others(setup: RigSetup, system: DynamicSystem) -> tuple[Dof, ...]:
    """Return as many DoFs that were not measured, in the directions that were; the drive point stays."""
    measured = {dof.point for dof in setup.responses}
    directions = {dof.direction for dof in setup.responses}
    free = [d for d in system.dofs if d.direction in directions and d.point not in measured]
    at_drive = [dof for dof in setup.responses if dof.point == setup.drive.point]
    chosen = _spread(free, len(setup.responses) - len(at_drive))
    return (*at_drive, *(replace(dof, sign=1) for dof in chosen)) if chosen else ()
