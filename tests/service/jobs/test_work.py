"""One job done: how it ends, and what the book says of it."""

import os
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NoReturn

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import CancelledError
from modallab.diagnosis.options import DiagnosisOptions
from modallab.fe.catalogued import STRUCTURES
from modallab.jobs import work
from modallab.jobs.book import JobBook
from modallab.jobs.destination import Destination
from modallab.jobs.diagnosing import DiagnosisInputs
from modallab.jobs.inline import InlineRunner
from modallab.jobs.runner import JobState
from modallab.jobs.settings import JOB
from modallab.jobs.tasks import DIAGNOSIS, TASKS
from modallab.jobs.work import Reporter, perform
from modallab.rig.analyser import Analyser
from modallab.rig.hardware import Noise
from modallab.rig.setup import RigSetup
from modallab.store.place import StorePlace, open_store

RIG = RigSetup(
    drives=(Dof(1, "Y"),),
    responses=(Dof(1, "Y"), Dof(9, "Y"), Dof(21, "Y")),
    analyser=Analyser(averages=20),
    noise=Noise(1e-3, 1e-3),
)


def measuring(place: StorePlace, **changed: Any) -> dict[str, Any]:
    """Return the arguments of a virtual test of the beam."""
    store = open_store(place)
    ids = {
        "structure_id": store.structures.add(STRUCTURES["chapter-5-beam"](), owner="me"),
        "rig_id": store.rigs.add(RIG, owner="me"),
    }
    return ids | {"effects": [], "route": "drawn", "seed": 1} | changed


def test_a_job_done_twice_stores_once_and_keeps_its_result(place: StorePlace, book: JobBook) -> None:
    job = book.open("measure_and_store", measuring(place), owner="me")
    store, into = open_store(place), Destination("me", job.result_id)
    for _ in range(2):
        TASKS[job.task](store, lambda _f, _m: None, into, **job.arguments)
    assert [entry.id for entry in store.measurements.list(owner="me", limit=9)] == [job.result_id]
    assert perform(place, job.id) is None
    assert book.get(job.id).state is JobState.SUCCEEDED
    assert perform(place, job.id) is None  # nothing is left to be done


def test_an_error_of_the_numerics_ends_the_job_with_its_own_words(place: StorePlace, book: JobBook) -> None:
    job = book.open("measure_and_store", measuring(place, rig_id="gone"), owner="me")
    assert perform(place, job.id) is None
    error = book.get(job.id).error
    assert error is not None
    assert (error["code"], error["context"]["value"]) == ("not_found", "gone")


def test_a_fault_of_ours_is_told_to_the_log_and_not_to_the_owner(
    place: StorePlace, book: JobBook, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_given: object, **_more: object) -> NoReturn:
        raise ZeroDivisionError("secret")

    monkeypatch.setattr(work, "TASKS", {"measure_and_store": broken})
    job = book.open("measure_and_store", {}, owner="me")
    fault = perform(place, job.id)
    assert fault is not None
    assert "ZeroDivisionError: secret" in fault
    error = book.get(job.id).error
    assert error is not None
    assert error["code"] == "internal"
    assert "secret" not in str(error)
    with pytest.raises(RuntimeError, match="secret"):
        InlineRunner(book, place).submit("measure_and_store", {}, owner="me")


def test_work_that_nobody_wants_any_more_stops_and_stores_nothing(
    place: StorePlace, book: JobBook, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(work, "JOB", replace(JOB, progress_interval=0.0))
    job = book.open("measure_and_store", measuring(place, route="sampled"), owner="me")
    start = JobBook.start

    def cancelled_meanwhile(self: JobBook, job_id: str) -> bool:
        wanted = start(self, job_id)
        self.cancel(job_id)
        return wanted

    monkeypatch.setattr(JobBook, "start", cancelled_meanwhile)
    assert perform(place, job.id) is None
    assert book.get(job.id).state is JobState.CANCELLED
    assert not open_store(place).measurements.holds(job.result_id)


def test_an_orphan_stops(book: JobBook, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(work, "JOB", replace(JOB, progress_interval=0.0))
    report = Reporter(book, book.open("measure_and_store", {}, owner="me").id)
    report(0.1, "still somebody's child")
    monkeypatch.setattr(os, "getppid", lambda: 1)
    with pytest.raises(CancelledError):
        report(0.2, "an orphan")


def test_progress_is_written_ten_times_a_second_at_most(book: JobBook) -> None:
    job = book.open("measure_and_store", {}, owner="me")
    report = Reporter(book, job.id)
    for n in range(1000):
        report(n / 1000, str(n))
    assert int(book.get(job.id).message) < 900  # a thousand calls take well under a second


class Sealed:
    """A shelf of truths that nobody may open."""

    def __getattr__(self, name: str) -> NoReturn:
        raise AssertionError(f"the truth was asked for: {name}")


def test_a_diagnosis_never_asks_for_the_truth(place: StorePlace) -> None:
    store = open_store(place)
    given: Mapping[str, Any] = measuring(place)
    TASKS["measure_and_store"](store, lambda _f, _m: None, Destination("me", "test"), **given)
    store.truths = Sealed()  # type: ignore[assignment]
    inputs = DiagnosisInputs(given["structure_id"], "test")
    arguments = DIAGNOSIS.arguments(inputs, DiagnosisOptions(suspects=("extra_mass",), max_effects=1))
    TASKS["diagnose_and_store"](store, lambda _f, _m: None, Destination("me", "found"), **arguments)
    found = store.diagnoses.get("found")
    np.testing.assert_array_equal(found.curves.measured.shape[1:], (3, 1))
