"""Assignments over HTTP: made, measured within limits, answered, marked."""

import csv
import io
from typing import Any

import numpy as np
import pytest

from modallab.store.assignments import AssignmentBook
from modallab.store.viewer import EVERYONE
from tests.service.api.authorisation import BEAM, School, assignment, open_school

pytestmark = pytest.mark.usefixtures("unpadded")
LATER, LONG_AGO = "2040-01-01T00:00:00Z", "2020-01-01T00:00:00Z"


@pytest.fixture(scope="module")
def school(service: Any) -> School:
    """Two classes."""
    return open_school(service)


def created(school: School, **changes: Any) -> dict[str, Any]:
    """Return the instructor's reply to a new assignment."""
    body = assignment(school.ids["class"]) | changes
    reply = school.send("instructor", "POST", "/v1/assignments", json=body)
    assert reply.status_code == 201, reply.text
    made: dict[str, Any] = reply.json()
    return made


def trial(school: School, id: str, caller: str = "student", headers: Any = None, **body: Any) -> Any:
    """Return the reply to a request of a measurement."""
    return school.send(caller, "POST", f"/v1/assignments/{id}/measurements", json=body, headers=headers or {})


def measurement(school: School, id: str, caller: str = "student", **body: Any) -> str:
    """Return the id of a measurement of an assignment."""
    reply = trial(school, id, caller, **body)
    assert reply.status_code == 202, reply.text
    job = school.send(caller, "GET", f"/v1/jobs/{reply.json()['id']}").json()
    assert job["state"] == "succeeded", job
    return str(job["result_id"])


def arrays(school: School, id: str) -> dict[str, np.ndarray]:
    """Return the arrays of a measurement."""
    reply = school.send("student", "GET", f"/v1/measurements/{id}/arrays")
    return dict(np.load(io.BytesIO(reply.content)))


def frf(school: School, id: str) -> np.ndarray:
    """Return the FRFs of a measurement."""
    return arrays(school, id)["values"]


def hidden_from(school: School, id: str, caller: str = "student") -> Any:
    """Return the effects of a student."""
    book: AssignmentBook = school.service.app.state.assignments
    return book.get(id, viewer=EVERYONE).hidden_from(school.ids[caller])


def test_the_instructor_sees_everything_and_a_student_what_is_asked(school: School) -> None:
    made = created(school, rubric={"coefficients": 1, "expected": {"E": {"value": 0.9}}}, deadline=LATER)
    assert made["hidden"] == assignment("")["hidden"]
    assert made["expected"] == {"E": {"value": 0.9, "tolerance": 0.1}}
    seen = school.send("student", "GET", f"/v1/assignments/{made['id']}").json()
    assert not {"hidden", "expected", "revealed", "secret", "seed"} & set(seen)
    assert seen["rubric"]["names"] == ["E"]
    assert seen["choices"] == assignment("")["choices"]
    assert seen["deadline"] == "2040-01-01T00:00:00.000000+00:00"
    assert seen in school.send("student", "GET", "/v1/assignments").json()["items"]
    assert school.send("student", "GET", f"/v1/structures/{seen['structure_id']}").status_code == 200


def test_a_student_measures_as_chosen_within_the_limits(school: School) -> None:
    id = created(school)["id"]
    made = measurement(school, id, rig={"drive": "9:+Y", "analyser": {"averages": 7}})
    seen = school.send("student", "GET", f"/v1/measurements/{made}").json()
    assert seen["inputs"] == ["9:+Y"]
    assert seen["rig"]["analyser"]["averages"] == 7
    assert seen["seed"] is None
    assert school.send("student", "GET", f"/v1/assignments/{id}").json()["measurements"] == [made]
    for body, field in (
        ({"rig": {"drive": "2:+Y"}}, "drive"),
        ({"rig": {"analyser": {"averages": 51}}}, "analyser.averages"),
        ({"rig": {"noise": {"force": 0.0, "response": 0.0}}}, "noise.force"),
        ({"route": "expected"}, "route"),
    ):
        reply = trial(school, id, **body)
        assert (reply.status_code, reply.json()["context"]["field"]) == (422, field)
    assert len(school.send("student", "GET", f"/v1/assignments/{id}").json()["measurements"]) == 1


def test_no_number_between_whole_ones_is_drawn_for_a_student(school: School) -> None:
    limits = {"between": [1.0, 2.0]}
    hidden = [{"kind": "integrated_response", "at": None, "parameters": {"integrations": limits}}]
    body = assignment(school.ids["class"]) | {"hidden": hidden}
    reply = school.send("instructor", "POST", "/v1/assignments", json=body)
    assert reply.status_code == 422, reply.text
    assert reply.json()["context"]["allowed"] == [-2, -1, 0, 1, 2]


def test_the_hidden_effects_act(school: School) -> None:
    choices = {"route": {"one_of": ["expected"]}}
    id = created(school, choices=choices)["id"]
    made = measurement(school, id)
    (effect,) = hidden_from(school, id)
    structure = school.made("/v1/structures", BEAM)
    rig = school.send("student", "GET", f"/v1/measurements/{made}").json()["rig_id"]
    sent = {"kind": effect.kind, "at": str(effect.at), "parameters": effect.parameters}
    test = {"structure_id": structure, "rig_id": rig, "route": "expected"}
    right = frf(school, school.made("/v1/measurements", test | {"effects": [sent]}))
    bare = frf(school, school.made("/v1/measurements", test))
    assert np.array_equal(frf(school, made), right)
    assert not np.allclose(right, bare, rtol=0.01)


def test_each_student_has_effects_of_the_own(school: School) -> None:
    id = created(school)["id"]
    first, second = (hidden_from(school, id, caller)[0] for caller in ("student", "same class"))
    assert first.parameters != second.parameters


def test_the_quota_is_a_students_and_refusals_do_not_count(school: School) -> None:
    id = created(school, quota=2)["id"]
    for _ in range(2):
        measurement(school, id)
    refused = trial(school, id).json()
    assert (refused["status"], refused["code"], refused["context"]["allowed"]) == (422, "assignment", 2)
    assert measurement(school, id, "same class")


def test_a_repeated_request_returns_the_same_measurement(school: School) -> None:
    id = created(school, quota=2)["id"]
    key = {"Idempotency-Key": "my-first"}
    first, again = (trial(school, id, headers=key).json() for _ in range(2))
    assert first["result_id"] is not None
    assert first["result_id"] == again["result_id"]
    other = trial(school, id, headers=key, rig={"drive": "9:+Y"})
    assert (other.status_code, other.json()["code"]) == (409, "key_reused")
    assert len(school.send("student", "GET", f"/v1/assignments/{id}").json()["measurements"]) == 1


def test_the_same_choice_again_shares_no_value_where_there_is_noise(school: School) -> None:
    id = created(school)["id"]
    tests = [arrays(school, measurement(school, id)) for _ in range(3)]
    for name in ("values", "coherence", "force_spectrum", "response_spectrum"):
        assert not np.any(tests[0][name] == tests[1][name]), name
    # Independent complex errors e_i give e_1 - e_3 and e_2 - e_3 a correlation of 1/2, and their unit vectors
    # pi/8 (1 + 1/32 + ..) = 0.406; one error repeated gives 1, none 0. The FRFs share the error of the force:
    # of 161 independent lines the mean scatters by 0.7 / sqrt(161) = 0.055: 3.5 of them.
    first, second = (test["values"] - tests[2]["values"] for test in tests[:2])
    unit = first.conj() * second / np.abs(first * second)
    assert abs(unit.real.mean() - 0.406) < 0.19


def test_a_seed_is_not_a_students_to_choose(school: School) -> None:
    reply = trial(school, created(school)["id"], seed=1)
    assert (reply.status_code, reply.json()["context"]["field"]) == (422, "body.seed")


def test_after_the_deadline_nothing_is_measured_or_answered(school: School) -> None:
    id = created(school, deadline=LONG_AGO)["id"]
    for path in ("measurements", "submissions"):
        reply = school.send("student", "POST", f"/v1/assignments/{id}/{path}", json={})
        assert (reply.status_code, reply.json()["context"]["field"]) == (422, "deadline")


def test_an_answer_is_marked_and_the_class_table_has_it(school: School) -> None:
    id = created(school, rubric={"kind": 2, "place": 2, "size": 1, "words": 3})["id"]
    (effect,) = hidden_from(school, id)
    right = {"kind": effect.kind, "at": str(effect.at), "parameters": effect.parameters}
    reply = school.send(
        "student",
        "POST",
        f"/v1/assignments/{id}/submissions",
        json={"effects": [right], "words": "=1+1, seen"},
    )
    assert reply.status_code == 201, reply.text
    assert (reply.json()["marks"]["points"], reply.json()["marks"]["maximum"]) == (5, 5)
    assert school.send("student", "GET", f"/v1/assignments/{id}").json()["submission"] == reply.json()
    own = school.send("student", "GET", f"/v1/assignments/{id}/marks").json()["items"]
    assert [row["name"] for row in own] == ["student"]
    table = school.send("instructor", "GET", f"/v1/assignments/{id}/marks", headers={"Accept": "text/csv"})
    rows = {row["name"]: row for row in csv.DictReader(io.StringIO(table.text))}
    assert set(rows) == {"student", "same class", "revoked"}
    assert (rows["student"]["points"], rows["student"]["words"]) == ("5.0", "'=1+1, seen")
    assert rows["same class"]["points"] == ""


def test_the_instructor_gives_points_for_the_words(school: School) -> None:
    id = created(school, hidden=[], rubric={"kind": 2, "place": 0, "size": 0, "words": 3})["id"]
    (student,) = (row["student"] for row in marks_of(school, "student", id))
    path = f"/v1/assignments/{id}/marks/{student}/words"
    grade = {"points": 2.5, "comment": "Right, but short."}
    early = school.send("instructor", "PUT", path, json=grade)
    assert (early.status_code, early.json()["context"]["field"]) == (404, "student")
    school.send("student", "POST", f"/v1/assignments/{id}/submissions", json={"words": "It is as modelled."})
    reply = school.send("instructor", "PUT", path, json=grade)
    assert reply.status_code == 200, reply.text
    (row,) = marks_of(school, "student", id)
    assert row["submission"] == reply.json()
    marks = row["submission"]["marks"]
    assert (marks["points"], marks["maximum"]) == (4.5, 5.0)
    assert marks["marks"][-1]["reasons"] == ["Right, but short."]
    table = school.send("instructor", "GET", f"/v1/assignments/{id}/marks", headers={"Accept": "text/csv"})
    cells = {entry["name"]: entry for entry in csv.DictReader(io.StringIO(table.text))}["student"]
    assert (cells["points_for_words"], cells["words"]) == ("2.5", "It is as modelled.")
    refused = school.send("instructor", "PUT", path, json={"points": 4}).json()
    assert (refused["context"]["field"], refused["context"]["allowed"]["maximum"]) == ("points", 3.0)


def marks_of(school: School, caller: str, id: str) -> list[dict[str, Any]]:
    reply = school.send(caller, "GET", f"/v1/assignments/{id}/marks")
    items: list[dict[str, Any]] = reply.json()["items"]
    return items


def test_answers_are_as_many_as_the_assignment_says(school: School) -> None:
    id = created(school, submissions=1)["id"]
    path = f"/v1/assignments/{id}/submissions"
    assert school.send("student", "POST", path, json={}).status_code == 201
    refused = school.send("student", "POST", path, json={}).json()
    assert (refused["code"], refused["context"]["field"]) == ("assignment", "submissions")


def test_what_was_hidden_is_told_after_the_reveal(school: School) -> None:
    sealed, told = (created(school, reveal=time)["id"] for time in (LATER, LONG_AGO))
    assert "revealed" not in school.send("student", "GET", f"/v1/assignments/{sealed}").json()
    (effect,) = hidden_from(school, told)
    assert school.send("student", "GET", f"/v1/assignments/{told}").json()["revealed"] == [
        {"kind": effect.kind, "at": str(effect.at), "parameters": effect.parameters}
    ]


def test_a_closed_assignment_is_gone_and_its_measurements_stay(school: School) -> None:
    id = created(school)["id"]
    made = measurement(school, id)
    assert school.send("instructor", "DELETE", f"/v1/assignments/{id}").status_code == 204
    assert school.send("student", "GET", f"/v1/assignments/{id}").status_code == 404
    assert school.send("student", "GET", f"/v1/measurements/{made}").status_code == 200
    assert school.send("student", "DELETE", f"/v1/measurements/{made}").status_code == 409


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"hidden": [{"kind": "extra_mass", "at": "99:+Y", "parameters": {"mass": 1}}]}, None),
        (
            {"hidden": [{"kind": "extra_mass", "at": "2:+Y", "parameters": {"mass": {"between": [2, 1]}}}]},
            None,
        ),
        (
            {"hidden": [{"kind": "extra_mass", "at": "2:+Y", "parameters": {"wrong": 1}}]},
            "effects.extra_mass",
        ),
        ({"choices": {"analyser.colour": {"one_of": ["red"]}}}, "choices.analyser.colour"),
        ({"choices": {"analyser.averages": {"between": [0, 5]}}}, "choices.analyser.averages"),
        ({"choices": {"route": {"one_of": ["magic"]}}}, "choices.route"),
        ({"diagnosis": "after_deadline"}, "deadline"),
        ({"deadline": LATER, "reveal": LONG_AGO}, "reveal"),
        (
            {
                "hidden": [{"kind": "cubic_stiffness", "at": "2:+Y"}],
                "choices": {"route": {"one_of": ["sampled", "drawn"]}},
            },
            "choices.route",
        ),
        ({"structure": "0" * 24}, "structure_id"),
        ({"class_id": "0" * 24}, "id"),
    ],
)
def test_an_assignment_that_cannot_be_measured_is_refused(
    school: School, changes: dict[str, Any], field: str | None
) -> None:
    body = assignment(school.ids["class"]) | changes
    reply = school.send("instructor", "POST", "/v1/assignments", json=body)
    assert reply.status_code in (404, 422), reply.text
    assert field is None or reply.json()["context"]["field"] == field
