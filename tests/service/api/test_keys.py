"""Keys over HTTP: told once, exchanged for cookies, and no way in for web pages of other origins."""

import csv
import io
from typing import Any

import pytest
from anyio import to_thread

from modallab.api.limits import JOB_STREAM
from modallab.api.runners import job_book
from modallab.store.keys import Role
from modallab.store.viewer import EVERYONE
from tests.service.api.authorisation import BEAM, RIG, School, open_school

TABLE = "number,name\r\n1,Müller\r\n2,a student\r\n"


@pytest.fixture(scope="module")
def school(service: Any) -> School:
    """Two classes."""
    return open_school(service)


def new_class(school: School) -> str:
    reply = school.send("instructor", "POST", "/v1/classes", json={"name": "new"})
    return f"/v1/classes/{reply.json()['id']}"


def test_a_key_is_told_once(school: School) -> None:
    body = {"name": "a program", "role": "service", "expires": "2040-01-01T01:00:00+01:00"}
    made = school.send("admin", "POST", "/v1/keys", json=body)
    assert made.headers["cache-control"] == "no-store"
    key = made.json()
    assert (key["name"], key["role"], key["expires"]) == (
        "a program",
        "service",
        "2040-01-01T00:00:00.000000+00:00",
    )
    told = school.send("admin", "GET", f"/v1/keys/{key['id']}")
    assert told.json() == {name: value for name, value in key.items() if name != "key"}
    listed = school.send("admin", "GET", "/v1/keys?limit=1").json()
    assert listed["items"] == [told.json()]
    assert listed["next"] == key["id"]
    assert school.send("admin", "GET", f"/v1/keys?limit=1&after={key['id']}").json()["items"] != [told.json()]


def test_who_sees_which_keys(school: School) -> None:
    names = {
        caller: {key["name"] for key in school.send(caller, "GET", "/v1/keys").json()["items"]}
        for caller in ("student", "instructor")
    }
    assert names == {"student": {"student"}, "instructor": {"instructor", "student", "same class", "revoked"}}


def test_a_class_list_comes_as_a_table_and_goes_as_one(school: School) -> None:
    path = f"{new_class(school)}/members"
    headers = {"Content-Type": "text/csv; charset=utf-8", "Accept": "text/csv"}
    reply = school.send("instructor", "POST", path, content=TABLE.encode("utf-8-sig"), headers=headers)
    assert reply.status_code == 201, reply.text
    assert reply.headers["cache-control"] == "no-store"
    rows = list(csv.DictReader(io.StringIO(reply.text)))
    assert [row["name"] for row in rows] == ["Müller", "a student"]
    signed_in = school.service.request(
        "GET", "/v1/sessions", headers={"Authorization": f"Bearer {rows[0]['key']}"}
    )
    assert (signed_in.json()["id"], signed_in.json()["name"]) == (rows[0]["id"], "Müller")


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (b"surname\nA\n", "no column `name`"),
        (b"", "no column `name`"),
        (b"name\n", "names"),
        (b"name\n\xff\n", "UTF-8"),
        (b"name\nA\nA\n", "each name once"),
        (b"name\n" + b"A" * 101 + b"\n", "names"),
        (b'name\n"' + b"A" * 200_000 + b'"\n', "cannot be read"),
    ],
)
def test_a_table_at_fault_adds_nobody(school: School, table: bytes, words: str) -> None:
    path = new_class(school)
    reply = school.send(
        "instructor", "POST", f"{path}/members", content=table, headers={"Content-Type": "text/csv"}
    )
    assert reply.status_code == 422, reply.text
    assert words in reply.json()["detail"]
    assert school.send("instructor", "GET", path).json()["members"] == []


def test_jobs_of_a_class_are_its_instructors_to_cancel_but_not_with_all_of_theirs(school: School) -> None:
    body = {
        "structure_id": school.made("/v1/structures", BEAM),
        "rig_id": school.made("/v1/rigs", RIG),
        "route": "expected",
    }
    job = school.send("student", "POST", "/v1/measurements", json=body).json()
    assert job["owner"] == school.ids["student"]
    listed = {
        (caller, query): [
            item["id"] for item in school.send(caller, "GET", f"/v1/jobs{query}").json()["items"]
        ]
        for caller in ("instructor", "other instructor", "admin")
        for query in ("", f"?owner={school.ids['student']}")
    }
    found = [key for key, ids in listed.items() if ids == [job["id"]]]
    assert found == [(caller, f"?owner={school.ids['student']}") for caller in ("instructor", "admin")]
    assert school.send("instructor", "DELETE", "/v1/jobs").json()["cancelled"] == []


def test_the_truth_is_told_to_the_key_that_measured(school: School) -> None:
    body = {
        "structure_id": school.made("/v1/structures", BEAM, "instructor"),
        "rig_id": school.made("/v1/rigs", RIG, "instructor"),
        "route": "expected",
    }
    measured = school.made("/v1/measurements", body, "instructor")
    school.service.app.state.classes.share(
        school.ids["class"],
        measured,
        viewer=school.service.app.state.keys.verified(school.keys["instructor"]).viewer,
    )
    statuses = {
        caller: (
            school.send(caller, "GET", f"/v1/measurements/{measured}").status_code,
            school.send(caller, "GET", f"/v1/measurements/{measured}/truth").status_code,
        )
        for caller in ("instructor", "admin", "student", "other student")
    }
    assert statuses == {
        "instructor": (200, 200),
        "admin": (200, 404),
        "student": (200, 403),
        "other student": (404, 403),
    }


def signed_in(school: School, caller: str) -> dict[str, str]:
    reply = school.service.request("POST", "/v1/sessions", json={"key": school.keys[caller]})
    assert reply.status_code == 201, reply.text
    assert reply.json()["name"] == caller
    cookie, *attributes = reply.headers["set-cookie"].split("; ")
    assert {"HttpOnly", "SameSite=strict", "Path=/v1/"} <= set(attributes)
    assert school.keys[caller] not in cookie
    return {"Cookie": cookie}


def test_a_cookie_stands_for_the_key_until_it_is_signed_out(school: School) -> None:
    cookie = signed_in(school, "student")
    made = school.service.request("POST", "/v1/structures", json=BEAM, headers=cookie)
    assert made.json()["owner"] == school.ids["student"]
    out = school.service.request("DELETE", "/v1/sessions", headers=cookie)
    assert out.status_code == 204
    assert "Max-Age=0" in out.headers["set-cookie"]
    assert school.service.request("GET", "/v1/structures", headers=cookie).status_code == 401


@pytest.mark.parametrize("ending", ["revoked", "rotated", "signed out", "none"])
def test_a_stream_ends_soon_after_its_key_or_session(
    school: School, ending: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    keys, send = school.service.app.state.keys, school.service.request
    new = keys.create(ending, Role.STUDENT)
    bearer = {"Authorization": f"Bearer {new.text}"}
    opened = send("POST", "/v1/sessions", json={"key": new.text}).headers["set-cookie"].split("; ")[0]
    cookie = {"Cookie": opened}
    endings = {
        "revoked": lambda: keys.revoke(new.key.id, viewer=EVERYONE),
        "rotated": lambda: keys.rotate(new.key.id, viewer=EVERYONE),
        "signed out": lambda: send("DELETE", "/v1/sessions", headers=cookie),
        "none": lambda: None,
    }
    book = job_book(school.service.app.state.settings)
    job = book.open("measure_and_store", {}, owner=new.key.id)
    book.start(job.id)
    pauses = 0

    async def pause(seconds: float) -> None:
        nonlocal pauses
        pauses += 1
        if pauses == 1:
            await to_thread.run_sync(endings[ending])
        if pauses * seconds > 2 * JOB_STREAM.verification_interval:
            book.cancel(job.id)

    monkeypatch.setattr("modallab.api.jobs.sleep", pause)
    followed = send("GET", f"/v1/jobs/{job.id}/events", headers=cookie if ending == "signed out" else bearer)
    assert '"state":"running"' in followed.text
    assert ('"state":"cancelled"' in followed.text) is (ending == "none")


def test_a_key_in_the_header_opens_a_session_too(school: School) -> None:
    assert "set-cookie" in school.send("student", "POST", "/v1/sessions").headers
    assert school.send("no key", "POST", "/v1/sessions").status_code == 401


@pytest.mark.parametrize("caller", ["revoked", "expired"])
def test_a_key_that_does_not_count_opens_no_session(school: School, caller: str) -> None:
    reply = school.service.request("POST", "/v1/sessions", json={"key": school.keys[caller]})
    assert (reply.status_code, reply.json()["code"]) == (401, "unauthorized")
    assert reply.headers["www-authenticate"] == "Bearer"
    assert "set-cookie" not in reply.headers


def new_link(school: School, caller: str = "instructor") -> str:
    """Return the secret of a new link of the student."""
    reply = school.send(caller, "POST", f"/v1/keys/{school.ids['student']}/links")
    assert reply.status_code == 201, reply.text
    assert reply.headers["cache-control"] == "no-store"
    page, _, fragment = reply.json()["link"].partition("#")
    assert page == "/", "the secret is in no path and in no query"
    return str(fragment.removeprefix("once="))


def test_a_link_of_the_instructor_signs_a_student_in_once(school: School) -> None:
    secret = new_link(school)
    signing_in = {"json": {"link": secret}}
    reply = school.service.request("POST", "/v1/sessions", **signing_in)
    assert (reply.status_code, reply.json()["name"]) == (201, "student")
    cookie = {"Cookie": reply.headers["set-cookie"].split("; ")[0]}
    made = school.service.request("POST", "/v1/structures", json=BEAM, headers=cookie)
    assert made.json()["owner"] == school.ids["student"]
    again = school.service.request("POST", "/v1/sessions", **signing_in)
    assert (again.status_code, again.json()["code"]) == (401, "unauthorized")
    assert "set-cookie" not in again.headers
    assert signed_in(school, "student"), "the key counts as before"


def test_a_link_of_another_origins_page_signs_nobody_in(school: School) -> None:
    secret = new_link(school)
    headers = {"Sec-Fetch-Site": "cross-site"}
    refused = school.service.request("POST", "/v1/sessions", json={"link": secret}, headers=headers)
    assert refused.status_code == 403
    reply = school.service.request("POST", "/v1/sessions", json={"link": secret})
    assert reply.status_code == 201, "what is refused does not use a link up"


@pytest.mark.parametrize("body", [{}, {"key": "k", "link": "l"}])
def test_either_a_key_or_a_link_signs_in(school: School, body: dict[str, str]) -> None:
    reply = school.service.request("POST", "/v1/sessions", json=body)
    assert (reply.status_code, reply.json()["code"]) == (422, "invalid_request")
    assert "set-cookie" not in reply.headers


def test_a_link_of_a_revoked_key_is_refused_where_it_is_made(school: School) -> None:
    reply = school.send("instructor", "POST", f"/v1/keys/{school.ids['revoked']}/links")
    assert (reply.status_code, reply.json()["context"]["allowed"]) == (422, "a valid key")


FOREIGN = [
    {"Origin": "http://elsewhere.example"},
    {"Origin": "http://localhost:9999"},
    {"Origin": "null"},
    {"Sec-Fetch-Site": "cross-site"},
    {"Sec-Fetch-Site": "same-site", "Origin": "http://localhost:8000"},
]


@pytest.mark.parametrize("headers", FOREIGN)
def test_a_cookie_changes_nothing_on_behalf_of_another_origin(
    school: School, headers: dict[str, str]
) -> None:
    cookie = signed_in(school, "student")
    for method, path in (("POST", "/v1/structures"), ("DELETE", "/v1/jobs"), ("POST", "/v1/sessions")):
        reply = school.service.request(method, path, json=BEAM, headers=cookie | headers)
        assert (reply.status_code, reply.json()["code"]) == (403, "forbidden"), (method, path)
    # A key in a header is no cookie: only who knows it sends it.
    assert school.send("student", "POST", "/v1/structures", json=BEAM, headers=headers).status_code == 201


@pytest.mark.parametrize(
    "headers", [{"Origin": "http://localhost:8000"}, {"Sec-Fetch-Site": "same-origin"}, {}]
)
def test_the_services_own_page_works_with_a_cookie(school: School, headers: dict[str, str]) -> None:
    cookie = signed_in(school, "student")
    reply = school.service.request("POST", "/v1/structures", json=BEAM, headers=cookie | headers)
    assert reply.status_code == 201


def test_another_scheme_is_no_key(school: School) -> None:
    key = school.keys["admin"]
    for header in (key, f"Basic {key}", "Bearer", f"Bearer {key} {key}"):
        reply = school.service.request("GET", "/v1/rigs", headers={"Authorization": header})
        assert reply.status_code == 401, header
