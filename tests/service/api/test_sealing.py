"""Students cannot ask the service what an assignment hides from them."""

import io
import time
import zipfile
from typing import Any

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.core.progress import Progress
from modallab.jobs import inline, sealing
from modallab.jobs.book import JobBook
from modallab.jobs.postponed import DueJob
from modallab.jobs.work import end_due
from modallab.store.place import StorePlace, engine_of, open_store
from tests.service.api.authorisation import BEAM, RIG, School, open_school
from tests.service.api.test_assignments import LATER, LONG_AGO, created, measurement

pytestmark = pytest.mark.usefixtures("unpadded")
NOWHERE = "0" * 24  # a model that is not there: what is allowed fails for it, which takes no time
PARTS = {"macros": [[1, 2, 3, 4], [5, 6, 7, 8]], "parts": ["stiffness"]}


@pytest.fixture(scope="module")
def school(service: Any) -> School:
    """Two classes."""
    return open_school(service)


@pytest.fixture(scope="module")
def structure(school: School) -> str:
    """The student's own model of the beam."""
    return school.made("/v1/structures", BEAM)


@pytest.fixture(scope="module")
def off(school: School) -> str:
    """A measurement of an assignment without diagnosis."""
    return measurement(school, created(school)["id"])


def diagnose(school: School, structure: str, id: str, caller: str = "student", **more: Any) -> Any:
    """Return the reply to a diagnosis that has nothing to search."""
    body = {"structure_id": structure, "measurement_id": id, "suspects": ["polarity"], "max_effects": 1}
    return school.send(caller, "POST", "/v1/diagnoses", json=body | more)


def refusal(reply: Any) -> tuple[int, str, str]:
    problem = reply.json()
    return reply.status_code, problem["code"], problem["context"]["field"]


REFUSED = (422, "assignment", "measurement_id")


def test_a_diagnosis_and_what_tells_the_same_are_refused(school: School, structure: str, off: str) -> None:
    ids = {"structure_id": structure, "measurement_id": off}
    assert refusal(diagnose(school, structure, off)) == REFUSED
    model = school.made("/v1/modal-models", {"measurement_id": off, "method": "circle_fit", "n_modes": 3})
    correlation = ids | {"modal_model_id": model}
    assert refusal(school.send("student", "POST", "/v1/correlations", json=correlation)) == REFUSED
    update = ids | {"method": "frf_residual", "parameterisation": PARTS}
    assert refusal(school.send("student", "POST", "/v1/updates", json=update)) == REFUSED
    # modes are what the exercise is about
    pair = {"structure_id": structure, "modal_model_id": model}
    assert school.send("student", "POST", "/v1/correlations", json=pair).status_code == 201


def test_a_sealed_measurement_is_no_follow_up(school: School, structure: str, off: str) -> None:
    rig = school.made("/v1/rigs", RIG)
    own = school.made("/v1/measurements", {"structure_id": structure, "rig_id": rig})
    reply = diagnose(school, structure, own, follow_ups=[{"measurement_id": off}])
    assert refusal(reply) == REFUSED


def test_the_instructor_may_diagnose_what_students_may_not(school: School, off: str) -> None:
    assert diagnose(school, NOWHERE, off, "instructor").status_code == 404


@pytest.mark.parametrize(
    ("rule", "deadline", "status"),
    [("on", None, 404), ("off", LONG_AGO, 422), ("after_deadline", LATER, 422)],
)
def test_the_rule_of_the_assignment_counts(
    school: School, rule: str, deadline: str | None, status: int
) -> None:
    id = created(school, diagnosis=rule, deadline=LATER if deadline else None)["id"]
    made = measurement(school, id)
    assert diagnose(school, NOWHERE, made).status_code == status


def test_after_the_deadline_a_diagnosis_is_allowed(school: School, monkeypatch: pytest.MonkeyPatch) -> None:
    made = measurement(school, created(school, diagnosis="after_deadline", deadline=LATER)["id"])
    monkeypatch.setattr("modallab.api.assignments.seal.now", lambda: "2040-01-01T00:00:01.000000+00:00")
    assert diagnose(school, NOWHERE, made).status_code == 404


def test_no_test_of_an_assignment_and_none_of_others_is_repeated(school: School, structure: str) -> None:
    sealed = measurement(school, created(school, diagnosis="on")["id"])
    reply = diagnose(school, structure, sealed, act=True)
    assert refusal(reply) == (422, "assignment", "act")
    rig = school.made("/v1/rigs", RIG, "instructor")
    beam = school.made("/v1/structures", BEAM, "instructor")
    test = {"structure_id": beam, "rig_id": rig, "effects": [{"kind": "extra_mass", "at": "2:+Y"}]}
    shared = school.made("/v1/measurements", test, "instructor")
    path = f"/v1/classes/{school.ids['class']}/shares"
    assert school.send("instructor", "POST", path, json={"resource_id": shared}).status_code == 201
    assert diagnose(school, NOWHERE, shared).status_code == 404
    assert refusal(diagnose(school, structure, shared, act=True)) == (422, "assignment", "act")


def cut_and_rescaled(content: bytes) -> bytes:
    """Return an archive of FRFs with half of the lines, in another unit."""
    arrays = dict(np.load(io.BytesIO(content)))
    n = len(arrays["freq"])
    kept = {"freq": arrays["freq"][n // 4 : n // 2], "values": arrays["values"][n // 4 : n // 2] / 9.81}
    file = io.BytesIO()
    np.savez(file, **kept, outputs=arrays["outputs"], inputs=arrays["inputs"], kind=arrays["kind"])
    return file.getvalue()


@pytest.mark.parametrize("caller", ["student", "same class"])
@pytest.mark.parametrize("form", ["frf.uff", "thesis.frf", "arrays", "arrays.h5", "cut"])
def test_an_upload_of_a_sealed_measurement_is_recognised(
    school: School, off: str, form: str, caller: str
) -> None:
    path = f"/v1/measurements/{off}/{'arrays' if form == 'cut' else form}"
    content = school.send("student", "GET", path).content
    if form == "cut":
        content = cut_and_rescaled(content)
    name = {"cut": "frf.npz", "arrays": "frf.npz"}.get(form, form)
    data = {"averages": "100"} | ({"kind": "inertance"} if form == "thesis.frf" else {})
    sent = {"files": {"file": (name, content)}, "data": data}
    reply = school.send(caller, "POST", "/v1/measurements/import", **sent)
    assert reply.status_code == 201, reply.text
    model = school.made("/v1/structures", BEAM, caller)
    refused = diagnose(school, model, reply.json()["id"], caller, noise_floor=0.01)
    assert refusal(refused) == REFUSED


def test_an_upload_of_a_test_of_ones_own_is_none(school: School, structure: str) -> None:
    rig = school.made("/v1/rigs", RIG)
    own = school.made("/v1/measurements", {"structure_id": structure, "rig_id": rig, "seed": 5})
    content = school.send("student", "GET", f"/v1/measurements/{own}/arrays").content
    reply = school.send(
        "student",
        "POST",
        "/v1/measurements/import",
        files={"file": ("frf.npz", content)},
        data={"rig_id": rig},
    )
    assert diagnose(school, NOWHERE, reply.json()["id"], noise_floor=0.01).status_code == 404


def test_an_error_of_the_test_is_one_sentence_whatever_is_hidden(
    school: School, monkeypatch: pytest.MonkeyPatch
) -> None:
    id = created(school)["id"]

    def fail(*_: Any, **__: Any) -> None:
        raise InvalidInputError("extra_mass cannot be at 7:+Y", field="at", value="7:+Y", allowed=["x"])

    monkeypatch.setattr(sealing, "measured", fail)
    reply = school.send("student", "POST", f"/v1/assignments/{id}/measurements", json={})
    job = school.send("student", "GET", f"/v1/jobs/{reply.json()['id']}").json()
    assert job["state"] == "failed"
    assert job["error"]["detail"] == (
        "the test cannot be carried out as chosen; choose another, or ask the instructor"
    )
    assert "7:+Y" not in str(job)
    assert "extra_mass" not in str(job)


def test_the_duration_is_a_multiple_of_the_step(school: School, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sealing, "SEALING", sealing.SealingSettings(step=2.0, solution=0.1))
    monkeypatch.setattr(sealing, "_work_as_long", lambda *_: None)
    id = created(school)["id"]
    reply = school.send("student", "POST", f"/v1/assignments/{id}/measurements", json={})
    job = school.send("student", "GET", f"/v1/jobs/{reply.json()['id']}").json()
    assert (job["state"], job["fraction"]) == ("succeeded", 1.0)
    begun, ended = (np.datetime64(job[name][:26]) for name in ("started", "ended"))
    seconds = (ended - begun) / np.timedelta64(1, "s")
    assert seconds >= 2.0
    assert seconds % 2.0 == 0.0  # not about: what is beyond would tell
    made = school.send("student", "GET", f"/v1/measurements/{job['result_id']}").json()
    assert np.datetime64(made["created"][:26]) == ended


@pytest.mark.parametrize(
    ("worked", "least", "kept"),
    [(0.5, 2.0, 2.0), (2.5, 2.0, 4.0), (61.0, 120.0, 124.5), (121.0, 120.0, 124.5)],
)
def test_a_process_is_kept_for_steps_too(
    worked: float, least: float, kept: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = worked

    def sleep(seconds: float) -> None:
        nonlocal now
        now += seconds

    monkeypatch.setattr("modallab.jobs.sealing.time.monotonic", lambda: now)
    monkeypatch.setattr("modallab.jobs.sealing.time.sleep", sleep)
    monkeypatch.setattr(sealing, "SEALING", sealing.SealingSettings())
    sealing._keep_process(0.0, least, lambda *_: None)
    assert now == pytest.approx(kept)  # rounding of floats


@pytest.fixture
def done(school: School, monkeypatch: pytest.MonkeyPatch) -> tuple[str, StorePlace, DueJob]:
    """Id, store and entry of a job whose work is done and whose end is told in 100 s."""
    monkeypatch.setattr(sealing, "SEALING", sealing.SealingSettings(step=100.0, solution=0.1))
    monkeypatch.setattr(sealing, "_work_as_long", lambda *_: None)
    ends: list[tuple[StorePlace, DueJob]] = []
    monkeypatch.setattr(inline, "end_due", lambda *end: ends.append(end))
    monkeypatch.setattr(DueJob, "rest", lambda *_: 0.0)
    reply = school.send("student", "POST", f"/v1/assignments/{created(school)['id']}/measurements", json={})
    return reply.json()["id"], *ends[-1]


def test_nobody_sees_what_is_done_before_the_end_is_told(
    school: School, done: tuple[str, StorePlace, DueJob]
) -> None:
    id, place, due = done
    made = JobBook(engine_of(place), queue_length=0).get(id).result_id
    path = f"/v1/measurements/{made}"
    before = school.send("student", "GET", f"/v1/jobs/{id}").json()
    assert (before["state"], before["fraction"], before["ended"]) == ("running", 0.0, None)
    assert school.send("student", "GET", path).status_code == 404
    assert made not in school.send("student", "GET", "/v1/measurements").text
    end_due(place, due)
    assert school.send("student", "GET", f"/v1/jobs/{id}").json()["state"] == "succeeded"
    assert school.send("student", "GET", path).status_code == 200
    # an assignment's measurement as any other
    assert diagnose(school, NOWHERE, made).status_code == 422


def test_nothing_is_left_of_a_job_that_was_cancelled_after_its_work(
    school: School, done: tuple[str, StorePlace, DueJob]
) -> None:
    id, place, _ = done
    book, store = JobBook(engine_of(place), queue_length=0), open_store(place)
    made = book.get(id).result_id
    assert store.measurements.holds(made)
    assert school.send("student", "DELETE", f"/v1/jobs/{id}").json()["state"] == "cancelled"
    (due,) = book.due()
    end_due(place, due)
    assert not store.measurements.holds(made)
    assert book.due() == []
    assert school.send("student", "GET", f"/v1/jobs/{id}").json()["state"] == "cancelled"


@pytest.mark.parametrize("kind", ["extra_mass", "cubic_stiffness"])
def test_every_test_computes_for_a_multiple_of_the_estimate(
    school: School, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    computed: list[float] = []
    work = sealing._work_as_long

    def timed(began: float, step: float, progress: Progress) -> None:
        work(began, step, progress)
        computed.append((time.thread_time() - began) / step)

    monkeypatch.setattr(sealing, "_work_as_long", timed)
    monkeypatch.setattr(sealing, "SEALING", sealing.SealingSettings(step=0.01, solution=2.0, spare=0.0))
    measurement(school, created(school, hidden=[{"kind": kind, "at": "2:+Y"}])["id"])
    # The nonlinear test computes for 0.8 s, the linear one for 0.02 s; both are filled up to the estimate. A
    # step of the work and a look whether the job is wanted take some milliseconds.
    assert computed == [pytest.approx(round(computed[0]), abs=0.02)]
    assert computed[0] >= 1.0


@pytest.mark.parametrize(("transform", "slowness"), [(1e-9, 1e3), (1.0, 1.0)])
def test_a_slow_core_has_longer_estimates(
    monkeypatch: pytest.MonkeyPatch, transform: float, slowness: float
) -> None:
    """Without that a nonlinear test would take more than its estimate there, and be told by its duration."""
    monkeypatch.setattr(sealing, "SEALING", sealing.SealingSettings(transform_time=transform))
    found = sealing._relative_core_time()
    assert found >= slowness
    assert slowness > 1 or found == 1.0


def test_an_effect_that_the_chosen_rig_has_no_place_for_does_not_act(school: School) -> None:
    wire = {"kind": "polarity", "at": {"channels": ["4:+Y"]}}
    choices = {"responses": {"one_of": ["1:+Y", "4:+Y", "9:+Y"]}}
    id = created(school, hidden=[wire], choices=choices)["id"]
    assert measurement(school, id, rig={"responses": ["1:+Y", "9:+Y"]})
    assert measurement(school, id)


def test_nobody_but_the_instructor_is_told_the_truth(school: School, off: str) -> None:
    path = f"/v1/measurements/{off}/truth"
    statuses = {caller: school.send(caller, "GET", path).status_code for caller in ("student", "instructor")}
    assert statuses == {"student": 403, "instructor": 200}
    assert school.send("other instructor", "GET", path).status_code == 404
    assert school.send("instructor", "GET", path).json()["effects"][0]["kind"] == "extra_mass"
    assert zipfile.is_zipfile(
        io.BytesIO(school.send("student", "GET", f"/v1/measurements/{off}/arrays").content)
    )
