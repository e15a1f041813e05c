"""Sends whatever the OpenAPI document allows, and more, with keys, and tells which answers it does not name.

    python -m tests.faults.documented --minutes 5 --database sqlite --caller student

Every operation in turn, again and again: well-formed requests and wrong ones. Ids that exist lead further
than made-up ones, so most requests name what a student has made. SQLite stands for one process that answers
and works, PostgreSQL for a service and a worker.
"""

import argparse
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any

import httpx
import requests
import schemathesis
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis.errors import Unsatisfiable
from schemathesis.checks import not_a_server_error
from schemathesis.generation import GenerationMode
from schemathesis.specs.openapi import checks

from modallab.api.app import create_app
from modallab.api.runners import job_book
from modallab.api.settings import ServiceSettings
from modallab.jobs.inline import InlineRunner
from tests.databases import DATABASES, database
from tests.faults.site import wait_for
from tests.service.api.authorisation import School, fill, open_school
from tests.serving import Lab, free_port, running

CHECKS = [
    not_a_server_error,
    checks.status_code_conformance,
    checks.content_type_conformance,
    checks.response_headers_conformance,
    checks.response_schema_conformance,
]
_EXAMPLES = 4  # of an operation, a mode and a turn
_PATIENCE = 60.0  # s for one answer
_ANEW = ("/v1/keys", "/v1/sessions")  # what would change the caller's own key


@dataclass(frozen=True)
class Remote:
    """A service in another process, as `Service` is one in this; `app` has its data only."""

    app: Any
    lab: Lab

    def request(self, method: str, path: str, **given: Any) -> httpx.Response:
        """Return the reply to a request."""
        return self.lab.request(method, path.removeprefix("/v1"), **given)


class RemoteSchool(School):
    """A school whose jobs take their time."""

    def made(self, path: str, body: Any, caller: str = "student") -> str:
        """Return the id of what a caller makes, by a job or at once."""
        reply = self.send(caller, "POST", path, json=body)
        assert reply.is_success, reply.text
        if reply.status_code != 202:
            return str(reply.json()["id"])
        self.ids["job"] = reply.json()["id"]
        asked = _Asked(lambda: self.send(caller, "GET", f"/v1/jobs/{self.ids['job']}").json())
        job = wait_for(asked, self.ids["job"])  # type: ignore[arg-type]
        assert job["state"] == "succeeded", job
        return str(job["result_id"])


@dataclass(frozen=True)
class _Asked:
    """A lab that is asked with a key."""

    answer: Callable[[], Any]

    def json(self, _method: str, _path: str) -> Any:
        """Return the job."""
        return self.answer()


@contextmanager
def school_of(kind: str, data: Path) -> Iterator[tuple[RemoteSchool, str]]:
    """Yield a school with a service on a database, and the service's address."""
    port = free_port()
    with database(kind, data) as (url, schema), Lab(port) as lab:
        scaled = kind != "sqlite"
        environment = {"MODALLAB_DATABASE_URL": url, "MODALLAB_DATABASE_SCHEMA": schema} if scaled else {}
        given = {"database_url": url, "database_schema": schema} if scaled else {}
        place = ServiceSettings(data=data, **given)  # type: ignore[arg-type]
        place.store_place.prepare()
        if scaled:
            place.job_place.prepare()
        local = open_school(Remote(create_app(place, InlineRunner(job_book(place), place.store_place)), lab))  # type: ignore[arg-type]
        school = RemoteSchool(local.service, local.keys, local.ids)
        serving = ("serve", "--port", str(port), "--role", "api" if scaled else "all")
        with running(*serving, data=data, environment=environment):
            lab.wait_until_up()
            with (
                running("worker", "--executor-id", "one", data=data, environment=environment)
                if scaled
                else _nothing()
            ):
                fill(school)
                yield school, f"http://127.0.0.1:{port}"


@contextmanager
def _nothing() -> Iterator[None]:
    yield


@dataclass
class Tally:
    """What was sent and what came back."""

    cases: int = 0
    statuses: Counter[int] = field(default_factory=Counter)
    operations: set[str] = field(default_factory=set)
    faults: dict[str, str] = field(default_factory=dict)
    """Operations and kinds of faults, with one request each."""


def known_ids(school: School, path: str) -> Mapping[str, str]:
    """Return the ids that a path and a body may name."""
    ids = school.ids
    known = {f"{name}_id": id for name, id in ids.items()}
    shelf = path.removeprefix("/v1/").partition("/")[0]
    singular = {"diagnoses": "diagnosis", "studies": "study", "classes": "class"}.get(shelf, shelf[:-1])
    own = ids.get(singular.replace("-", "_"), ids["student"])
    return known | {"resource_id": ids["share"], "truth_id": ids["structure"], "id": own}


def send(case: Any, school: School, caller: str, address: str, tally: Tally) -> None:
    """Send a request, and note what is wrong with its answer."""
    known = known_ids(school, case.path)
    positive = case.meta is None or case.meta.generation.mode is GenerationMode.POSITIVE
    if isinstance(case.body, dict):
        case.body.update({name: id for name, id in known.items() if name in case.body})
    if positive and case.method != "DELETE" and not case.path.startswith(_ANEW):
        for name in set(case.path_parameters or {}) & set(known):
            case.path_parameters[name] = known[name]
    headers = {"Authorization": f"Bearer {school.keys[caller]}"}
    tally.cases += 1
    operation = f"{case.method} {case.path}"
    tally.operations.add(operation)
    try:
        reply = case.call(base_url=address, headers=headers, timeout=_PATIENCE)
    except requests.RequestException as error:
        tally.faults.setdefault(f"{operation}: no answer", f"{case.as_curl_command()}\n  {error}")
        return
    tally.statuses[reply.status_code] += 1
    # Of a stream the document describes the text, and the check takes that for a description of each event.
    is_stream = reply.headers["content-type"][0].startswith("text/event-stream")
    try:
        case.validate_response(reply, checks=CHECKS[:-1] if is_stream else CHECKS)
    except schemathesis.errors.SchemathesisError as error:
        tally.faults.setdefault(f"{operation}: invalid", str(error))
    except BaseExceptionGroup as found:
        for failure in found.exceptions:
            text = f"{case.as_curl_command()}\n  {reply.status_code} {reply.text[:400]}\n  {failure}"
            tally.faults.setdefault(f"{operation}: {type(failure).__name__} {reply.status_code}", text)


def in_turn(
    school: School, caller: str, address: str, tally: Tally, *, turn: int, examples: int = _EXAMPLES
) -> Iterator[None]:
    """Send requests to every operation, and yield after each; turns differ in what they send."""
    chosen = settings(
        max_examples=examples,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    document = school.service.app.openapi()
    for result in schemathesis.openapi.from_dict(document).get_all_operations():
        operation: Any = result.ok()  # type: ignore[union-attr]
        for mode in GenerationMode:
            strategy = operation.as_strategy(generation_mode=mode)
            sending = given(case=strategy)(lambda case: send(case, school, caller, address, tally))
            with suppress(Unsatisfiable):  # nothing about a request without parameters can be wrong
                chosen(seed(turn)(sending))()
        # A queue that is full answers nothing else.
        school.send(caller, "DELETE", "/v1/jobs")
        yield


def answered(school: School, caller: str, address: str, seconds: float) -> Tally:
    """Return what came of all operations, in turn, until the time is over."""
    tally, end = Tally(), time.monotonic() + seconds
    for turn in count():
        for _ in in_turn(school, caller, address, tally, turn=turn):
            if time.monotonic() > end:
                return tally
    raise AssertionError("the time never ends")


def main() -> None:
    """Send, and print what came back."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--database", choices=DATABASES, nargs="*", default=list(DATABASES))
    parser.add_argument("--caller", nargs="*", default=["instructor", "student"])
    options = parser.parse_args()
    for kind in options.database:
        for caller in options.caller:
            with tempfile.TemporaryDirectory() as folder, school_of(kind, Path(folder)) as (school, address):
                tally = answered(school, caller, address, 60.0 * options.minutes)
            n = sum(number for status, number in tally.statuses.items() if status >= 500)
            sent = f"{tally.cases} cases of {len(tally.operations)} operations"
            print(f"{kind}, {caller}: {sent}, {n} of them 5xx, {len(tally.faults)} faults")
            print(f"  statuses {dict(sorted(tally.statuses.items()))}")
            for name, text in tally.faults.items():
                print(f"  {name}\n  {text}", flush=True)


if __name__ == "__main__":
    main()
