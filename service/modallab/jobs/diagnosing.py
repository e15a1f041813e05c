"""Diagnoses, and the further tests that they ask for; what finds out is never told how a test was made."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from modallab.core.dof import Dof
from modallab.core.errors import CancelledError, ModalLabError
from modallab.core.progress import Progress, part
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.predicting.follow_up import FollowUp
from modallab.diagnosis.result import Diagnosis
from modallab.jobs.destination import Destination
from modallab.jobs.measuring import measure_again
from modallab.rig.change import Change
from modallab.rig.measurement import Measurement
from modallab.store.base import Store

Json = Any

MOST_TESTS = 2  # further tests that are run for one diagnosis
FINDING = 0.85  # share of a round's progress that is the diagnosis, the rest its further test


@dataclass(frozen=True)
class _Test:
    """A further test: its measurement, and what was changed for it."""

    measurement_id: str
    change: Change


@dataclass(frozen=True)
class _Question:
    """What a diagnosis was asked, as ids and plain values."""

    structure_id: str
    measurement_id: str
    suspects: list[str] | None
    hold_out_fraction: float
    hold_out: list[str]
    max_effects: int
    seed: int
    tolerances: dict[str, float]
    noise_floor: float | None

    def answered(self, store: Store, tests: Sequence[_Test], progress: Progress) -> Diagnosis:
        """Return the diagnosis: of the model, and of measurements as anyone may read them."""
        return diagnose(
            store.structures.get(self.structure_id),
            self._read(store, self.measurement_id),
            suspects=self.suspects,
            hold_out_fraction=self.hold_out_fraction,
            hold_out=[Dof.parse(text) for text in self.hold_out],
            tolerances=Tolerances.of(self.tolerances),
            follow_ups=[FollowUp(self._read(store, t.measurement_id), t.change) for t in tests],
            max_effects=self.max_effects,
            seed=self.seed,
            progress=progress,
        )

    @property
    def options(self) -> dict[str, Any]:
        """What was asked beside model, measurements and seed, as a request has it."""
        asked: dict[str, Any] = {
            "suspects": "all" if self.suspects is None else self.suspects,
            "hold_out": {"fraction": self.hold_out_fraction, "dofs": self.hold_out},
            "max_effects": self.max_effects,
        }
        if self.tolerances:
            asked["tolerances"] = self.tolerances
        return asked if self.noise_floor is None else asked | {"noise_floor": self.noise_floor}

    def _read(self, store: Store, measurement_id: str) -> Measurement:
        """Return a measurement as anyone may read it, with the random error that was stated."""
        measurement: Measurement = store.measurements.get(measurement_id)
        return replace(measurement, noise_floor=self.noise_floor)

    def keep(
        self,
        store: Store,
        into: Destination,
        found: Diagnosis,
        tests: Sequence[_Test],
        earlier: Sequence[str],
    ) -> None:
        """Keep the findings, and beside them model and rig with what was added."""
        asked = {"structure_id": self.structure_id, "measurement_id": self.measurement_id}
        asked |= {f"follow_up_{i}": test.measurement_id for i, test in enumerate(tests, 1)}
        asked |= {f"earlier_{i}": id for i, id in enumerate(earlier, 1)}
        model, rig = into.beside("structure"), into.beside("rig")
        found = replace(found, request_options=self.options)
        with store.together() as batch:
            batch.structures.add(found.structure, owner=into.owner, inputs=asked, id=model)
            batch.rigs.add(found.setup, owner=into.owner, inputs=asked, id=rig)
            inputs = asked | {"extended_structure_id": model, "extended_rig_id": rig}
            batch.diagnoses.add(found, owner=into.owner, inputs=inputs, seed=self.seed, id=into.id)


def diagnose_and_store(
    store: Store,
    progress: Progress,
    into: Destination,
    *,
    structure_id: str,
    measurement_id: str,
    suspects: list[str] | None,
    hold_out_fraction: float,
    hold_out: list[str],
    max_effects: int,
    seed: int,
    tolerances: dict[str, float] | None = None,
    follow_ups: Json = (),
    act: bool = False,
    noise_floor: float | None = None,
) -> None:
    """Find what a model lacks and keep it; where told to act, run the tests proposed and ask again.

    Every diagnosis and every further test is kept under an id that follows from the job's: an attempt
    that dies is taken up where it was.
    """
    asked = _Question(
        structure_id,
        measurement_id,
        suspects,
        hold_out_fraction,
        hold_out,
        max_effects,
        seed,
        tolerances or {},
        noise_floor,
    )
    tests = [_Test(one["measurement_id"], Change.read(one["changed"])) for one in follow_ups]
    if act:
        _act(store, progress, into, asked, tests)
    else:
        asked.keep(store, into, asked.answered(store, tests, progress), tests, ())


def _act(store: Store, progress: Progress, into: Destination, asked: _Question, tests: list[_Test]) -> None:
    """Diagnose, run the test that is proposed, diagnose again, until none is proposed."""
    earlier: list[str] = []
    rounds = 1 + MOST_TESTS
    for n in range(rounds):
        between = Destination(into.owner, into.beside(f"diagnosis/{n + 1}"))
        if store.diagnoses.holds(between.id):
            found = store.diagnoses.get(between.id)
        else:
            found = asked.answered(store, tests, part(progress, n / rounds, (n + FINDING) / rounds))
        if n == MOST_TESTS or found.next_test is None:
            break
        asked.keep(store, between, found, tests, earlier)
        test = _Test(into.beside(f"measurement/{n + 1}"), Change.read(found.next_test.change))
        measuring = part(progress, (n + FINDING) / rounds, (n + 1) / rounds)
        if why := _refused(store, measuring, into.owner, asked.measurement_id, test, len(tests) + 1):
            found = replace(found, notes=(*found.notes, f"the next test could not be run: {why}"))
            break
        earlier.append(between.id)
        tests = [*tests, test]
    asked.keep(store, into, found, tests, earlier)


def _refused(
    store: Store, progress: Progress, owner: str, first_id: str, test: _Test, number: int
) -> ModalLabError | None:
    """Run a further test; return why if it cannot be."""
    try:
        measure_again(
            store,
            progress,
            Destination(owner, test.measurement_id),
            measurement_id=first_id,
            change=test.change,
            number=number,
        )
    except CancelledError:
        raise
    except ModalLabError as error:
        return error
    return None
