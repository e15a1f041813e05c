"""Every route, asked by everybody: exact statuses. A route without a row here fails.

Each row states what happens when `CALLERS` ask for something that a student of the instructor's class owns.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from fastapi.routing import iter_route_contexts

from modallab.api.document import operations
from tests.service.api.authorisation import (
    BEAM,
    CALLERS,
    PARTS,
    POINTS,
    RIG,
    School,
    answered_assignment,
    assignment,
    discarded,
    fill,
    new_assignment,
    new_class,
    new_member,
    new_share,
    open_school,
    student_id,
    study,
    throwaway,
)

pytestmark = pytest.mark.usefixtures("unpadded")
DOCUMENT = json.loads((Path(__file__).parents[3] / "docs" / "openapi.json").read_text(encoding="utf-8"))
OPERATIONS = {
    operation["operationId"]: (method.upper(), path) for path, method, operation in operations(DOCUMENT)
}
# Other content types of operations: their routes are not in the document.
OPERATIONS |= {
    "import_modal_file": OPERATIONS["import_modal_model"],
    "add_listed_members": OPERATIONS["add_members"],
}
NOBODY_ID = "0" * 24


@dataclass(frozen=True)
class Row:
    """What is sent, and the statuses in the order of `CALLERS`."""

    statuses: tuple[int, ...]
    """Of each caller."""
    owner: int = 200
    """Of the student whose things are asked for."""
    id: str | Callable[[School], str] = ""
    """Name of the id in the path, or what makes a new one for each request."""
    query: str = ""
    body: Callable[[dict[str, str]], Any] | None = None
    form: Callable[[School], dict[str, Any]] | None = None
    paths: dict[str, str | Callable[[School], str]] = field(default_factory=dict)


def owned(status: int = 200, **more: Any) -> Row:
    """Return the row of what exists for its owner, the owner's instructor and administrators alone."""
    return Row((401, 404, 404, status, status, 401, 401), owner=status, **more)


def anyone(status: int = 200, **more: Any) -> Row:
    """Return the row of what every person's key may do."""
    return Row((401, status, status, status, status, 401, 401), owner=status, **more)


def teachers(status: int = 200, **more: Any) -> Row:
    """Return the row of what is for instructors, of their own classes, and for administrators."""
    return Row((401, 403, 403, status, status, 401, 401), owner=403, **more)


def of_class(status: int = 200, **more: Any) -> Row:
    """Return the row of what is for all members of a class, its instructor and administrators."""
    return Row((401, 404, status, status, status, 401, 401), owner=status, **more)


def removal(shelf: str) -> Row:
    """Return the row of the removal of a new thing for each request."""
    return owned(204, id=lambda school: throwaway(school, shelf))


def public(status: int = 200, **more: Any) -> Row:
    """Return the row of what needs no key, and heeds none."""
    return Row((status,) * len(CALLERS), owner=status, **more)


def of(*names: str, **more: Any) -> Callable[[dict[str, str]], Any]:
    """Return what makes a body of ids and further fields."""
    return lambda ids: {f"{name}_id": ids[name] for name in names} | more


def unread(_: School) -> dict[str, Any]:
    """Return the form of an import that is refused before its file is read."""
    return {"files": {"file": ("model.bdf", b"")}, "data": {"damping": "?"}}


def listed(_: School) -> dict[str, Any]:
    """Return a class list as a table."""
    return {"content": "name\nsomebody\n", "headers": {"Content-Type": "text/csv"}}


def modes_file(school: School) -> dict[str, Any]:
    """Return the form of an import of modes."""
    reply = school.send("student", "GET", f"/v1/modal-models/{school.ids['modal_model']}/modes.uff")
    return {"files": {"file": ("modes.uff", reply.content)}}


def measured(school: School) -> dict[str, Any]:
    """Return the form of an import on the student's rig."""
    reply = school.send("student", "GET", f"/v1/measurements/{school.ids['measurement']}/frf.uff")
    return {"files": {"file": ("frf.uff", reply.content)}, "data": {"rig_id": school.ids["rig"]}}


FIT = "?mode=1&response=1:%2BY"
MODES = {"modes": [{"frequency": 20.0, "loss_factor": 0.01, "shape": [1.0]}], "dofs": ["1:+Y"]}
NAMES: dict[str, Any] = {"names": ["somebody"]}

ROWS: dict[str, Row] = {
    "get_health": public(),
    "get_ready": public(),
    "get_version": public(),
    "list_members": anyone(paths={"family": "effects"}),
    "list_limits": anyone(),
    # structures
    "create_structure": anyone(201, body=lambda _: BEAM),
    # refused for its damping law: a file that is read takes a process and two seconds
    "import_structure": anyone(422, form=unread),
    "list_structures": anyone(),
    "get_structure": owned(id="structure"),
    "get_structure_body": owned(id="structure"),
    "describe_structure": owned(id="structure", body=of(name="new")),
    "delete_structure": removal("structures"),
    "change_structure": owned(
        201,
        id="structure",
        body=of(changes=[{"members": [1], "property": "modulus", "factor": 1.1}]),
    ),
    "get_modes": owned(id="structure"),
    "get_mode_arrays": owned(id="structure"),
    "get_frf": owned(id="structure", query="?drive=1:%2BY&responses=1:%2BY&frequency_max=100&n_lines=9"),
    "get_geometry": owned(id="structure"),
    "get_geometry_uff": owned(id="structure"),
    "get_reduced": owned(id="structure", query="?kind=guyan&masters=1:%2BY&masters=9:%2BY"),
    "make_synthetic_modes": owned(201, id="structure", body=of(count=2, dofs=POINTS)),
    "expand_modes": owned(201, id="structure", body=of("modal_model", reduction="serep")),
    # rigs
    "create_rig": anyone(201, body=lambda _: RIG),
    "list_rigs": anyone(),
    "get_rig": owned(id="rig"),
    "get_rig_body": owned(id="rig"),
    "get_checks": owned(id="rig", query="?structure_id={structure}"),
    "describe_rig": owned(id="rig", body=of(name="new")),
    "delete_rig": removal("rigs"),
    # measurements
    "start_measurement": owned(202, body=of("structure", "rig", route="expected")),
    "import_measurement": owned(201, form=measured),
    "list_measurements": anyone(),
    "get_measurement": owned(id="measurement"),
    "get_measurement_arrays": owned(id="measurement"),
    "get_measurement_hdf5": owned(id="measurement"),
    "get_measurement_uff": owned(id="measurement"),
    "get_measurement_frf_text": owned(id="measurement"),
    # the measurement kept neither: its owner, too, is told that there is nothing
    "get_records": owned(404, id="measurement"),
    "get_estimates": owned(404, id="measurement"),
    "get_curves": owned(id="measurement"),
    "get_indicators": owned(id="measurement"),
    "get_reciprocity": owned(id="measurement"),
    "get_log": owned(id="measurement"),
    # to the key alone that made it, and to no student
    "get_truth": Row((401, 403, 403, 404, 404, 401, 401), owner=403, id="measurement"),
    "describe_measurement": owned(id="measurement", body=of(name="new")),
    "delete_measurement": removal("measurements"),
    # modal models
    "start_modal_model": owned(202, body=of("measurement", method="circle_fit", n_modes=2)),
    "import_modal_model": anyone(201, body=lambda _: MODES),
    "import_modal_file": anyone(201, form=modes_file),
    "list_modal_models": anyone(),
    "get_modal_model": owned(id="modal_model"),
    "get_modal_model_arrays": owned(id="modal_model"),
    "get_fit": owned(id="modal_model", query=FIT),
    "get_chart": owned(id="global_model"),
    "get_resynthesised": owned(id="modal_model"),
    "get_modal_reciprocity": owned(id="modal_model", query="?other={modal_model}"),
    "get_modal_model_uff": owned(id="modal_model"),
    "select_from_modal_model": owned(201, id="modal_model", body=of(drop=[1])),
    "describe_modal_model": owned(id="modal_model", body=of(name="new")),
    "delete_modal_model": removal("modal_models"),
    # what is made of them
    "create_correlation": owned(201, body=of("structure", "modal_model")),
    "list_correlations": anyone(),
    "get_correlation": owned(id="correlation"),
    "get_correlation_arrays": owned(id="correlation"),
    "describe_correlation": owned(id="correlation", body=of(name="new")),
    "delete_correlation": removal("correlations"),
    "start_update": owned(
        202, body=of("structure", "modal_model", method="one_shot", parameterisation=PARTS)
    ),
    "list_updates": anyone(),
    "get_update": owned(id="update"),
    "get_update_arrays": owned(id="direct_update"),
    "get_update_covariance": owned(id="update"),
    "get_update_sample": owned(id="update"),
    "describe_update": owned(id="update", body=of(name="new")),
    "delete_update": removal("updates"),
    "start_study": owned(202, body=study),
    "list_studies": anyone(),
    "get_study": owned(id="study"),
    "get_study_arrays": owned(id="study"),
    "describe_study": owned(id="study", body=of(name="new")),
    "delete_study": removal("studies"),
    # this diagnosis explains everything: there is nothing to adopt
    "adopt_unknown_effect": owned(422, id="diagnosis"),
    # the measurement has no random error
    "start_diagnosis": owned(202, body=of("structure", "measurement", suspects=["polarity"])),
    "list_diagnoses": anyone(),
    "get_diagnosis": owned(id="diagnosis"),
    "get_diagnosis_arrays": owned(id="diagnosis"),
    "get_diagnosis_report": owned(id="diagnosis"),
    "describe_diagnosis": owned(id="diagnosis", body=of(name="new")),
    "delete_diagnosis": removal("diagnoses"),
    # everybody's own; refused for its file, not for who sends it
    "export_project": anyone(),
    "import_project": anyone(422, form=lambda _: {"files": {"file": ("project.zip", b"")}}),
    # the trash
    "list_trash": anyone(),
    "restore_from_trash": owned(id=discarded),
    "remove_from_trash": owned(204, id=discarded),
    # jobs
    "list_jobs": anyone(),
    "cancel_all_jobs": anyone(),
    "get_job": owned(id="job"),
    "stream_job": owned(id="job"),
    "cancel_job": owned(id="job"),
    # keys
    "create_key": Row(
        (401, 403, 403, 403, 201, 401, 401), owner=403, body=lambda _: {"name": "new", "role": "student"}
    ),
    "list_keys": anyone(),
    "get_key": owned(id="student"),
    "rotate_key": Row((401, 404, 404, 201, 201, 401, 401), owner=404, id=new_member),
    "create_link": Row((401, 404, 404, 201, 201, 401, 401), owner=404, id=new_member),
    "revoke_key": Row((401, 404, 404, 204, 204, 401, 401), owner=404, id=new_member),
    "create_class": teachers(201, body=lambda _: {"name": "new"}),
    "list_classes": teachers(),
    "get_class": teachers(id="class"),
    "close_class": teachers(204, id=new_class),
    "add_members": teachers(201, id=new_class, body=lambda _: NAMES),
    "add_listed_members": teachers(201, id=new_class, form=listed),
    "share_with_class": teachers(201, id="class", body=lambda ids: {"resource_id": ids["share"]}),
    "withdraw_from_class": teachers(204, id="class", paths={"resource_id": new_share}),
    # assignments: of the class
    "create_assignment": teachers(201, body=lambda ids: assignment(ids["class"])),
    "list_assignments": anyone(),
    "get_assignment": of_class(id="assignment"),
    "close_assignment": teachers(204, id=new_assignment),
    "start_assignment_measurement": of_class(202, id=new_assignment, body=of()),
    "submit_answer": of_class(201, id=new_assignment, body=of()),
    "get_marks": of_class(id="assignment"),
    "grade_words": teachers(id=answered_assignment, body=of(points=2), paths={"student": student_id}),
    "get_session": anyone(),
    "delete_session": anyone(204),
    # for whoever has a key that counts
    "create_session": anyone(201),
}


@pytest.fixture(scope="module")
def school(service: Any) -> School:
    """Two classes; everything that the rows ask for is a student's of the first one."""
    school = open_school(service)
    fill(school)
    return school


def answer(school: School, caller: str, name: str, id: str | None = None) -> Any:
    """Return the reply to a caller's request of an operation."""
    row, (method, path) = ROWS[name], OPERATIONS[name]
    names = {"id": row.id, **row.paths}
    for parameter, source in names.items():
        value = source(school) if callable(source) else school.ids.get(source, source)
        path = path.replace(f"{{{parameter}}}", id if id is not None and parameter == "id" else value)
    given = {} if row.body is None else {"json": row.body(school.ids)}
    given |= {} if row.form is None else row.form(school)
    return school.send(caller, method, path + row.query.format(**school.ids), **given)


def test_every_route_has_a_row_and_every_row_a_route(service: Any) -> None:
    contexts = iter_route_contexts(service.app.routes)
    routes = {context.name for context in contexts if str(context.path).startswith("/v1/")}
    assert set(ROWS) == set(OPERATIONS) == routes


@pytest.mark.parametrize("name", OPERATIONS)
def test_a_route_answers_everybody_as_its_row_says(school: School, name: str) -> None:
    row = ROWS[name]
    replies = {caller: answer(school, caller, name) for caller in (*CALLERS, "student")}
    statuses = {caller: reply.status_code for caller, reply in replies.items()}
    expected = dict(zip(CALLERS, row.statuses, strict=True)) | {"student": row.owner}
    assert statuses == expected, {caller: reply.text[:300] for caller, reply in replies.items()}
    codes = {401: "unauthorized", 403: "forbidden", 404: "not_found"}
    for reply in replies.values():
        if reply.status_code in codes:
            assert reply.headers["content-type"] == "application/problem+json"
            assert reply.json()["code"] == codes[reply.status_code]
            documented = DOCUMENT["paths"][OPERATIONS[name][1]][OPERATIONS[name][0].lower()]["responses"]
            assert str(reply.status_code) in documented


@pytest.mark.parametrize("name", [name for name, row in ROWS.items() if row.id and row.statuses[1] == 404])
def test_what_is_not_for_a_student_is_answered_as_what_does_not_exist(school: School, name: str) -> None:
    foreign, absent = (answer(school, "other student", name, id) for id in (None, NOBODY_ID))
    id = foreign.request.url.path.split("/")[3]
    assert foreign.json() == json.loads(absent.text.replace(NOBODY_ID, id))


SESSIONS = {"create_session", "get_session", "delete_session"}


@pytest.mark.parametrize("name", OPERATIONS)
def test_the_role_service_is_for_programs_that_watch_the_service(school: School, name: str) -> None:
    allowed = {"get_health", "get_ready", "get_version", "list_limits", "list_keys", *SESSIONS}
    if name in ("get_key", "rotate_key", "create_link", "revoke_key"):  # of others
        assert answer(school, "service", name).status_code == 404
    else:
        assert (answer(school, "service", name).status_code < 300) == (name in allowed)


def test_metrics_are_for_administrators_and_for_programs_that_watch_the_service(school: School) -> None:
    callers = ("no key", "student", "instructor", "admin", "service", "revoked")
    statuses = [school.send(caller, "GET", "/metrics").status_code for caller in callers]
    assert statuses == [401, 403, 403, 200, 200, 401]
