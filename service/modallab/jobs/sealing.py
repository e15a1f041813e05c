"""Measurements of assignments: nothing about the job tells what is hidden."""

import math
import time
from dataclasses import dataclass, replace

import numpy as np

from modallab.assignments.terms import AssignmentError
from modallab.core.arrays import FloatArray
from modallab.core.errors import CancelledError, InvalidInputError, ModalLabError
from modallab.core.place import EffectSpec
from modallab.core.progress import Progress
from modallab.core.settings import Settings, setting
from modallab.fe.structure import Structure
from modallab.jobs.destination import Destination
from modallab.jobs.durations import duration_of_stepped_measurement
from modallab.jobs.measuring import MeasurementOptions, measured
from modallab.jobs.postponed import Postponed
from modallab.rig.effect import build
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.store.base import Store, Trial, Truth
from modallab.store.viewer import UNPUBLISHED


@dataclass(frozen=True)
class SealingSettings(Settings):
    """Times of measurements of assignments."""

    step: float = setting(
        5.0,
        unit="s",
        doc="step to which their durations are rounded up",
        derived="well above the differences between effects of a linear test, 0.1 s",
    )
    solution: float = setting(
        1.0,
        unit="s",
        doc="time of a nonlinear test before its first record",
        derived="measured on one core: 0.7 s",
    )
    spare: float = setting(
        2.0,
        unit="1",
        doc="ratio of the shortest duration to the estimate",
        derived="other jobs on the same core",
    )
    samples: int = setting(
        4096,
        unit="samples",
        doc="samples of the work that fills up a test",
        derived="a tenth of a millisecond",
    )
    transform_time: float = setting(
        5e-5,
        unit="s",
        doc="time of two transforms of these samples on a core where no test exceeds its estimate",
        tuned="half of that of a core on which nonlinear tests take 1.2 times their estimate",
    )
    timing: float = setting(
        0.05, unit="s", doc="time for which the transforms are timed", derived="500 of them on a slow core"
    )
    look: float = setting(
        0.5, unit="s", doc="time until a job that waits sees that it was cancelled", derived="as other jobs"
    )


SEALING = SealingSettings()
_IMPOSSIBLE = "the test cannot be carried out as chosen; choose another, or ask the instructor"


@dataclass(frozen=True)
class SealedInputs:
    """What a measurement of an assignment is made from."""

    structure_id: str
    rig_id: str
    assignment_id: str
    student: str
    """Id of the student's key."""
    number: int
    """Number of the student's measurement."""
    instructor: str
    """Id of the instructor's key, whose the truth is."""


def measure_sealed_and_store(
    store: Store, progress: Progress, into: Destination, inputs: SealedInputs, options: MeasurementOptions
) -> Postponed:
    """Run the virtual test of an assignment; store the measurement without seed, and the instructor's truth.

    Progress, errors and duration are the same whatever is hidden. The student has the measurement when the
    job ends, see `publish_sealed`.
    """
    began, computed = time.monotonic(), time.thread_time()
    structure, setup = store.structures.get(inputs.structure_id), store.rigs.get(inputs.rig_id)
    truth = Truth(inputs.structure_id, possible_effects(options.effects, structure, setup))

    def mute(_fraction: float, _message: str) -> None:
        progress(0.0, "measuring")

    estimate = SEALING.solution + duration_of_stepped_measurement(setup, options.route).seconds
    estimate *= (
        _relative_core_time()
    )  # on a slow core a nonlinear test would exceed it, which a linear one never does
    later = Postponed(SEALING.spare * estimate, SEALING.step)
    if store.measurements.holds(into.id):
        return later  # done by an attempt that died later
    measurement: Measurement | None = None
    try:
        made = measured(store, mute, truth, setup, options.route, options.seed)
        measurement = replace(made, seed=None)
    except CancelledError:
        raise
    except ModalLabError:  # told at the time at which a good one ends
        pass
    _work_as_long(computed, estimate, progress)
    _keep_process(began, later.least, progress)
    if measurement is None:
        return replace(later, error=AssignmentError(_IMPOSSIBLE))
    with store.together() as batch:
        batch.measurements.add(measurement, owner=UNPUBLISHED, inputs={"rig_id": inputs.rig_id}, id=into.id)
        batch.truths.add(truth, measurement_id=into.id, owner=inputs.instructor)
    return later


def publish_sealed(store: Store, into: Destination, inputs: SealedInputs, at: str) -> None:
    """Give the measurement of an assignment to the student; it is entered as made at that time."""
    with store.together() as batch:
        batch.measurements.hand_over(into.id, owner=into.owner, created=at)
        batch.trials.fulfil(Trial(inputs.assignment_id, inputs.student, inputs.number), into.id)


def withdraw_sealed(store: Store, into: Destination) -> None:
    """Remove the measurement of a job that was cancelled before its end."""
    if store.measurements.holds(into.id):
        store.measurements.remove(into.id)


def _work_as_long(began: float, step: float, progress: Progress) -> None:
    """Compute until the time on the processor is a multiple of a step: busy machines stretch all tests alike.

    Parameters
    ----------
    began
        s, time on the processor at which the test began.
    """
    if SEALING.step == 0:
        return
    steps = math.ceil((time.thread_time() - began) / step)
    work, looked = np.ones(SEALING.samples), time.thread_time()
    while (now := time.thread_time()) < began + steps * step:
        work = _transformed(work)
        if now - looked > SEALING.look:  # seldom: each look waits for the database, and tests look seldom
            looked = now
            progress(0.0, "measuring")


def _transformed(work: FloatArray) -> FloatArray:
    """Return the samples, to the spectrum and back."""
    return np.asarray(np.fft.irfft(np.fft.rfft(work), len(work)))


def _relative_core_time() -> float:
    """Return how much longer this core takes than the one that estimates are for; at least 1.

    Timed anew for every test: other work on the same machine changes it.
    """
    if SEALING.step == 0:
        return 1.0
    work, n, began = np.ones(SEALING.samples), 0, time.thread_time()
    while (spent := time.thread_time() - began) < SEALING.timing:
        work, n = _transformed(work), n + 1
    return max(1.0, spent / (n * SEALING.transform_time))


def possible_effects(
    effects: tuple[EffectSpec, ...], structure: Structure, setup: RigSetup
) -> tuple[EffectSpec, ...]:
    """Return the effects whose places exist in a test: those of others have no influence on it."""
    return tuple(spec for spec in effects if _is_possible(spec, structure, setup))


def _is_possible(spec: EffectSpec, structure: Structure, setup: RigSetup) -> bool:
    try:
        build(spec).check(structure, setup)
    except InvalidInputError:
        return False
    return True


def _keep_process(began: float, least: float, progress: Progress) -> None:
    """Wait after the work until shortly before the next step: the next job in the process begins then."""
    step = min(least, SEALING.step)
    if step == 0:
        return
    # The end is entered after that: at a step of its own it would be told at the next one.
    before = SEALING.look if step == SEALING.step else 0.0
    steps = math.ceil((max(time.monotonic() - began, least) + before) / step)
    while (rest := began + steps * step - before - time.monotonic()) > 0:
        progress(0.0, "measuring")
        time.sleep(min(rest, SEALING.look))
