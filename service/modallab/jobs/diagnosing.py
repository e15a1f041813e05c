"""Diagnoses and the further tests they propose; a diagnosis never sees the truth of a test."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

from modallab.core.errors import CancelledError, ModalLabError
from modallab.core.progress import Progress, part
from modallab.diagnosis.diagnose import diagnose_with_options
from modallab.diagnosis.options import DiagnosisOptions
from modallab.diagnosis.predicting.follow_up import FollowUp
from modallab.diagnosis.result import Diagnosis
from modallab.jobs.destination import Destination
from modallab.jobs.measuring import measure_again
from modallab.jobs.settings import JOB
from modallab.rig.change import Change
from modallab.store.base import Store


@dataclass(frozen=True)
class FurtherTest:
    """A further test: its measurement, and what was changed for it, as `Change.plain`."""

    measurement_id: str
    changed: Mapping[str, Any]

    def read(self, store: Store) -> FollowUp:
        """Return the test with its measurement."""
        return FollowUp(store.measurements.get(self.measurement_id), Change.read(self.changed))


@dataclass(frozen=True)
class DiagnosisInputs:
    """Stored things that a diagnosis is made from."""

    structure_id: str
    measurement_id: str
    follow_ups: tuple[FurtherTest, ...] = ()

    def with_test(self, test: FurtherTest) -> Self:
        """Return the inputs with one more further test."""
        return replace(self, follow_ups=(*self.follow_ups, test))

    def diagnose(self, store: Store, options: DiagnosisOptions, progress: Progress) -> Diagnosis:
        """Return the diagnosis of the model from the measurements, without their truths."""
        return diagnose_with_options(
            store.structures.get(self.structure_id),
            store.measurements.get(self.measurement_id),
            options,
            follow_ups=[test.read(store) for test in self.follow_ups],
            progress=progress,
        )

    def keep(
        self,
        store: Store,
        into: Destination,
        diagnosis: Diagnosis,
        earlier: Sequence[str],
    ) -> None:
        """Store the diagnosis, and the model and rig extended by the added effects."""
        sources = {"structure_id": self.structure_id, "measurement_id": self.measurement_id}
        sources |= {f"follow_up_{i}": test.measurement_id for i, test in enumerate(self.follow_ups, 1)}
        sources |= {f"earlier_{i}": id for i, id in enumerate(earlier, 1)}
        model, rig = into.derived_id("structure"), into.derived_id("rig")
        with store.together() as batch:
            batch.structures.add(diagnosis.structure, owner=into.owner, inputs=sources, id=model)
            batch.rigs.add(diagnosis.setup, owner=into.owner, inputs=sources, id=rig)
            inputs = sources | {"extended_structure_id": model, "extended_rig_id": rig}
            batch.diagnoses.add(diagnosis, owner=into.owner, inputs=inputs, seed=diagnosis.seed, id=into.id)


def diagnose_and_store(
    store: Store, progress: Progress, into: Destination, inputs: DiagnosisInputs, options: DiagnosisOptions
) -> None:
    """Diagnose and store the result; with `act`, run the proposed tests and diagnose again.

    Every diagnosis and every further test is kept under an id that follows from the job's: an attempt
    that dies is taken up where it was.
    """
    if options.act:
        _act(store, progress, into, inputs, options)
    else:
        inputs.keep(store, into, inputs.diagnose(store, options, progress), ())


def _act(
    store: Store, progress: Progress, into: Destination, inputs: DiagnosisInputs, options: DiagnosisOptions
) -> None:
    """Diagnose, run the test that is proposed, diagnose again, until none is proposed."""
    earlier: list[str] = []
    rounds = 1 + JOB.further_tests
    for n in range(rounds):
        between = Destination(into.owner, into.derived_id(f"diagnosis/{n + 1}"))
        if store.diagnoses.holds(between.id):
            diagnosis = store.diagnoses.get(between.id)
        else:
            diagnosis = inputs.diagnose(
                store, options, part(progress, n / rounds, (n + JOB.diagnosis_share) / rounds)
            )
        if n == JOB.further_tests or diagnosis.next_test is None:
            break
        inputs.keep(store, between, diagnosis, earlier)
        test = FurtherTest(
            into.derived_id(f"measurement/{n + 1}"), Change.read(diagnosis.next_test.change).plain
        )
        measuring = part(progress, (n + JOB.diagnosis_share) / rounds, (n + 1) / rounds)
        if why := _refused(store, measuring, into.owner, inputs, test):
            note = f"the next test could not be run: {why}"
            diagnosis = replace(diagnosis, notes=(*diagnosis.notes, note))
            break
        earlier.append(between.id)
        inputs = inputs.with_test(test)
    inputs.keep(store, into, diagnosis, earlier)


def _refused(
    store: Store, progress: Progress, owner: str, inputs: DiagnosisInputs, test: FurtherTest
) -> ModalLabError | None:
    """Run a further test; return why if it cannot be."""
    try:
        measure_again(
            store,
            progress,
            Destination(owner, test.measurement_id),
            measurement_id=inputs.measurement_id,
            change=Change.read(test.changed),
            number=len(inputs.follow_ups) + 1,
        )
    except CancelledError:
        raise
    except ModalLabError as error:
        return error
    return None
