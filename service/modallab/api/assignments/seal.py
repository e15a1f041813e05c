"""What students may not do with measurements of assignments."""

from collections.abc import Sequence

from modallab.assignments.recognition import is_copy
from modallab.assignments.terms import AssignmentError
from modallab.store.base import Store
from modallab.store.keys import now
from modallab.store.viewer import Viewer, Visibility


def check_may_diagnose(store: Store, viewer: Viewer, measurement_ids: Sequence[str]) -> None:
    """Raise unless the measurements may be compared with models line by line.

    An uploaded measurement counts as the one of an assignment of the viewer's class whose FRFs it has.

    Raises
    ------
    NotFoundError
        If one is not there.
    AssignmentError
        If an assignment does not allow it to students, or not yet.
    """
    if viewer.visibility is not Visibility.OWN:
        return
    time = now()
    assignments = store.trials.assignments_of(measurement_ids)
    for id in measurement_ids:
        store.measurements.check(id)
        if id in assignments and not assignments[id].allows_diagnosis(time):
            raise _refusal(id)
    # What was simulated here is not uploaded.
    uploaded = [id for id in measurement_ids if id not in assignments and not store.truths.holds(id)]
    if uploaded and viewer.class_id is not None:
        _check_uploaded(store, viewer.class_id, uploaded, time)


def _check_uploaded(store: Store, class_id: str, ids: Sequence[str], time: str) -> None:
    frfs = {id: store.measurements.get(id).frf for id in ids}
    for known_id, assignment in store.trials.of_class(class_id).items():
        if assignment.allows_diagnosis(time):
            continue
        known = store.unrestricted.measurements.get(known_id).frf
        for id, frf in frfs.items():
            if is_copy(frf, known):
                raise _refusal(id)


def _refusal(measurement_id: str) -> AssignmentError:
    return AssignmentError(
        "an assignment does not allow students to compare its measurements with models line by line",
        field="measurement_id",
        value=measurement_id,
        allowed="extraction of modes, and what is made of these; measurements of no assignment",
    )


def check_may_act(store: Store, viewer: Viewer, measurement_id: str) -> None:
    """Raise unless a measurement may be repeated with changes.

    Raises
    ------
    AssignmentError
        If it is of an assignment, or another's.
    """
    is_sealed = bool(store.trials.assignments_of([measurement_id]))
    if is_sealed or store.measurements.entry(measurement_id).owner != viewer.owner:
        raise AssignmentError(
            "only one's own tests are repeated, and none of an assignment",
            field="act",
            value="true",
            allowed="false, or a measurement of one's own",
        )
