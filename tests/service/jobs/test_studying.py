"""Studies as jobs: shared out, gathered, and the same whoever made the runs."""

from dataclasses import replace
from typing import Any, NoReturn

import pytest

from modallab.core.dof import Dof
from modallab.core.errors import CancelledError
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.jobs import studying, work
from modallab.jobs.book import JobBook
from modallab.jobs.inline import InlineRunner
from modallab.jobs.runner import JobState
from modallab.jobs.settings import JOB
from modallab.jobs.studying import StudyInputs
from modallab.jobs.tasks import STUDY
from modallab.jobs.work import ShareReporter, count_shares, perform, perform_share
from modallab.store.place import StorePlace, open_store
from modallab.updating.options import UpdateOptions
from modallab.updating.parameterisation import parameterise
from modallab.updating.studies.plan import NOISE_LEVELS, Division, Level, StudyPlan

TASK = "study_and_store"


def arguments(place: StorePlace) -> dict[str, Any]:
    """Return a study of the beam: two levels, one division, two seeds."""
    store, beam = open_store(place), STRUCTURES["chapter-5-beam"]()
    truth = change(beam, [MemberChange((11, 12), MemberProperty.MODULUS, factor=2.0)])
    plan = StudyPlan(
        "one_shot",
        tuple(Level(name, NOISE_LEVELS[name]) for name in ("NL1", "NL3")),
        (Division("each", parameterise([(n,) for n in range(1, 21)])),),
        (1, 2),
        8,
        tuple(Dof(node, "Y") for node in range(1, 22, 2)),
        UpdateOptions(),
    )
    ids = [store.structures.add(structure, owner="me") for structure in (beam, truth)]
    return STUDY.arguments(StudyInputs(*ids), plan)


def test_runs_made_apart_are_gathered_to_the_study_that_one_worker_makes(
    place: StorePlace, book: JobBook
) -> None:
    given = arguments(place)
    alone = InlineRunner(book, place).submit(TASK, given, owner="me")
    job = book.open(TASK, given, owner="me")
    n = count_shares(job)
    assert n == 4
    shares: list[Any] = [None] * n
    for index in reversed(range(n)):  # in whatever order
        shares[index], fault = perform_share(place, job.id, index)
        assert fault is None
    assert perform(place, job.id, shares) is None
    store = open_store(place)
    one, other = (store.studies.get(id) for id in (alone.result_id, job.result_id))
    assert one.runs == other.runs
    assert store.studies.npz(alone.result_id) == store.studies.npz(job.result_id)
    assert one.cells[0].suspected == 1.0
    assert store.studies.entry(job.result_id).inputs == {k: given[k] for k in ("structure_id", "truth_id")}


def test_a_fault_of_ours_costs_one_run_and_not_the_study(
    place: StorePlace, book: JobBook, monkeypatch: pytest.MonkeyPatch
) -> None:
    job = book.open(TASK, arguments(place), owner="me")
    shares = [perform_share(place, job.id, index)[0] for index in range(3)]

    def broken(*_given: object, **_more: object) -> NoReturn:
        raise ZeroDivisionError("secret")

    monkeypatch.setattr(studying, "run_once", broken)
    made, fault = perform_share(place, job.id, 3)
    assert made is None
    assert fault is not None
    assert "secret" in fault
    assert perform(place, job.id, [*shares, made]) is None
    study = open_store(place).studies.get(job.result_id)
    assert [run.succeeded for run in study.runs] == [True, True, True, False]
    assert study.runs[3].stopped_because == "the service failed at this run; its log says why"
    assert study.cells[1].n_failed == 1


def test_a_share_of_a_job_that_nobody_wants_makes_nothing(
    place: StorePlace, book: JobBook, monkeypatch: pytest.MonkeyPatch
) -> None:
    job = book.open(TASK, arguments(place), owner="me")
    monkeypatch.setattr(work, "JOB", replace(JOB, progress_interval=0.0))
    report = ShareReporter(book, job.id)
    report(0.5, "half of a share")
    assert book.get(job.id).fraction == 0.0  # of the job
    book.cancel(job.id)
    with pytest.raises(CancelledError):
        report(0.6, "still at it")
    assert perform_share(place, job.id, 0) == (None, None)


def test_what_was_removed_meanwhile_ends_the_study_with_its_name(place: StorePlace, book: JobBook) -> None:
    given = arguments(place)
    job = book.open(TASK, given, owner="me")
    open_store(place).structures.remove(given["truth_id"])
    made, fault = perform_share(place, job.id, 0)
    assert (made, fault) == (None, None)
    assert perform(place, job.id, [None] * 4) is None
    ended = book.get(job.id)
    assert ended.state is JobState.FAILED
    assert ended.error is not None
    assert (ended.error["code"], ended.error["context"]["value"]) == ("not_found", given["truth_id"])


def test_most_jobs_have_no_shares(book: JobBook) -> None:
    assert count_shares(book.open("measure_and_store", {}, owner="me")) == 0
