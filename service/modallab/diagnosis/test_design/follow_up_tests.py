"""Further tests that a laboratory could do, in the order of their cost, each with its purpose."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.dof import Dof
from modallab.diagnosis.test_design.settings import FOLLOW_UP
from modallab.fe.system import DynamicSystem
from modallab.rig.change import AddedMass, Change
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.setup import RigSetup


@dataclass(frozen=True)
class FollowUpOption:
    """Change against the first test, and its purpose."""

    change: Change
    """Change of the rig or of its settings."""
    why: str
    """Purpose of the change, in plain English."""


def follow_up_options(setup: RigSetup, system: DynamicSystem) -> Iterator[FollowUpOption]:
    """Yield the further tests that are considered, the cheapest first."""
    yield from _analyser_options(setup)
    several = len(setup.drives) > 1
    points = [d.point for d in setup.responses if d.point != setup.drive.point and not several]
    for drive in _evenly_spaced(points, FOLLOW_UP.n_drives):
        yield FollowUpOption(
            Change(drive=drive),
            f"with the force at {drive} the effects of shaker and force transducer move there, while effects "
            "of the structure stay",
        )
    if setup.exciter.kind == "shaker":
        yield FollowUpOption(
            Change(exciter="hammer"),
            "a hammer is not attached to the structure: effects of the shaker, the stinger and the force "
            "transducer vanish",
        )
    if responses := _unmeasured_responses(setup, system):
        yield FollowUpOption(
            Change(responses=responses),
            "other responses show other parts of the mode shapes, without the errors of single channels",
        )
    for at, place in ((None, "on the accelerometer"), (setup.drive.point, "at the drive point")):
        yield FollowUpOption(
            Change(added_mass=AddedMass(FOLLOW_UP.added_mass, at)),
            f"a known mass {place} shifts every natural frequency by an amount that differs between errors "
            "of mass, stiffness and sensitivity",
        )


def _analyser_options(setup: RigSetup) -> Iterator[FollowUpOption]:
    """Yield the further tests that differ in the settings of the analyser alone."""
    analyser = setup.analyser
    n_lines = FOLLOW_UP.refinement * (analyser.n_lines - 1) + 1
    yield FollowUpOption(
        Change(level_factor=FOLLOW_UP.level_factor),
        "at three times the force level a linear effect stays the same and a nonlinear effect changes",
    )
    yield FollowUpOption(
        Change(averages_factor=FOLLOW_UP.averages_factor),
        "ten times as many averages reduce every random error to a third",
    )
    yield FollowUpOption(
        Change(n_lines=n_lines),
        "half the line spacing resolves the bandwidth of resonances, reduces leakage and adds new lines",
    )
    if EXCITATIONS[analyser.excitation.kind].continuous > 0:
        yield FollowUpOption(
            Change(excitation="periodic_random", window="rectangular"),
            "an excitation that is periodic in the record causes no leakage and shows the true damping",
        )
    wider = FOLLOW_UP.refinement * analyser.frequency_max
    n_lines_to_wider = round((wider - analyser.frequency_min) / analyser.spacing) + 1
    yield FollowUpOption(
        Change(frequency_max=wider, n_lines=n_lines_to_wider),
        "twice the bandwidth shows further modes, in which the explanations may differ",
    )


def _evenly_spaced(dofs: list[Dof], count: int) -> list[Dof]:
    """Return at most `count` of the DoFs, evenly spaced in their list."""
    positions = np.linspace(0, len(dofs) - 1, min(count, len(dofs))).round().astype(int)
    return [dofs[i] for i in dict.fromkeys(positions.tolist())]


def _unmeasured_responses(setup: RigSetup, system: DynamicSystem) -> tuple[Dof, ...]:
    """Return as many unmeasured DoFs as responses, in the same directions; the drive point stays."""
    measured = {dof.point for dof in setup.responses}
    directions = {dof.direction for dof in setup.responses}
    free = [d for d in system.dofs if d.direction in directions and d.point not in measured]
    at_drive = [dof for dof in setup.responses if dof.point == setup.drive.point]
    chosen = _evenly_spaced(free, len(setup.responses) - len(at_drive))
    return (*at_drive, *(replace(dof, sign=1) for dof in chosen)) if chosen else ()
