"""Processes die; the jobs go on, and nothing half-written is served."""

import os
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.databases import database
from tests.serving import Lab, free_port, running

# What noise pulls far is many small steps away: the update runs to its last iteration, some seconds.
OPTIONS = {
    "max_iterations": 250,
    "location_tolerance": 1e-12,
    "tolerance": 1e-12,
    "suspect_threshold": 0.0,
    "max_step": 1e-3,
}
LONG = OPTIONS | {"max_iterations": 1000}
SYNTHETIC = {
    "count": 10,
    "dofs": [f"{n}:+{d}" for n in range(1, 31) for d in "XY"],
    "noise": {"eigenvalue": 0.05, "eigenvector": 0.1},
    "seed": 1,
}


def prepared(lab: Lab) -> dict[str, Any]:
    """Return the body of an update that takes some seconds."""
    model = lab.json("POST", "/structures", {"kind": "catalogue", "name": "bay"})["id"]
    changes = [{"members": [1, 2], "property": "density", "factor": 1.5}]
    truth = lab.json("POST", f"/structures/{model}/changes", {"changes": changes})["id"]
    modes = lab.json("POST", f"/structures/{truth}/synthetic-modes", SYNTHETIC)["id"]
    return {"structure_id": model, "modal_model_id": modes, "options": OPTIONS}


def found_by(lab: Lab, job: Any) -> Any:
    """Return what an update found, without what differs from run to run by design."""
    result = lab.json("GET", f"/updates/{job['result_id']}")
    return {name: result[name] for name in ("coefficients", "frequencies", "stopped_because", "iterations")}


def children(process: "subprocess.Popen[bytes]") -> list[int]:
    """Return the ids of a process's children."""
    found = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True, text=True)
    return [int(line) for line in found.stdout.split()]


def wait_for_the_end(processes: list[int]) -> list[int]:
    """Return the processes that are still at work after some seconds."""
    left: list[int] = []
    for _ in range(50):
        states = subprocess.run(
            ["ps", "-o", "pid=,stat=", "-p", ",".join(map(str, processes))], capture_output=True, text=True
        )
        found = [line.split() for line in states.stdout.splitlines()]
        left = [int(pid) for pid, state in found if not state.startswith("Z")]
        if not left:
            break
        time.sleep(0.1)
    return left


Embedded = tuple[Lab, list[str], Path]


Lasting = tuple[Lab, "subprocess.Popen[bytes]", Path]


@pytest.fixture(scope="module")
def lasting(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lasting]:
    """A service that none of its tests stops."""
    port, data = free_port(), tmp_path_factory.mktemp("lasting")
    with Lab(port) as lab, running("serve", "--port", str(port), data=data) as process:
        lab.wait_until_up()
        yield lab, process, data


@pytest.fixture
def embedded(tmp_path: Path) -> Iterator[Embedded]:
    """A client, and the arguments and folder of a service to be started."""
    port = free_port()
    data = tmp_path / "data"
    data.mkdir()
    with Lab(port) as lab:
        yield lab, ["serve", "--port", str(port)], data


def test_a_killed_service_ends_its_update_after_a_restart_with_the_same_result(
    embedded: Embedded,
) -> None:
    lab, arguments, data = embedded
    with running(*arguments, data=data) as process:
        lab.wait_until_up()
        body = prepared(lab)
        undisturbed = found_by(lab, lab.wait_for(lab.json("POST", "/updates", body)["id"], state="succeeded"))
        job = lab.json("POST", "/updates", body)["id"]
        lab.wait_for(job, state="running", fraction=0.2)
        process.send_signal(signal.SIGKILL)
        process.wait()
    with running(*arguments, data=data):
        lab.wait_until_up()
        known = lab.json("GET", "/updates")["items"]
        assert len(known) == 1, "a half-done update is shown"
        ended = lab.wait_for(job, state="succeeded")
        assert found_by(lab, ended) == undisturbed
        updates, structures = (lab.json("GET", f"/{shelf}")["items"] for shelf in ("updates", "structures"))
        assert len(updates) == 2
        assert len(structures) == 4  # the model, the truth, and one updated model for each update
    leftovers = list((data / "arrays").rglob("*.part"))
    assert leftovers == []


def test_a_killed_worker_process_is_replaced_and_the_job_ends(lasting: Lasting) -> None:
    lab, process, _ = lasting
    job = lab.json("POST", "/updates", prepared(lab))["id"]
    lab.wait_for(job, state="running", fraction=0.1)
    for child in children(process):
        os.kill(child, signal.SIGKILL)
    lab.wait_for(job, state="succeeded")


def test_a_stopped_service_goes_on_with_its_job_when_it_is_started_again(
    embedded: Embedded,
) -> None:
    lab, arguments, data = embedded
    with running(*arguments, data=data) as process:
        lab.wait_until_up()
        job = lab.json("POST", "/updates", prepared(lab))["id"]
        lab.wait_for(job, state="running", fraction=0.1)
        workers = children(process)
        process.terminate()
        assert process.wait(15) in (0, -signal.SIGTERM)
        assert not wait_for_the_end(workers)
    with running(*arguments, data=data):
        lab.wait_until_up()
        lab.wait_for(job, state="succeeded")


def test_a_cancelled_job_makes_room_for_the_next(lasting: Lasting) -> None:
    lab, _, _ = lasting
    body = prepared(lab)
    job = lab.json("POST", "/updates", body | {"options": LONG})["id"]
    lab.wait_for(job, state="running", fraction=0.01)
    short = lab.json("POST", "/updates", body | {"options": {"max_iterations": 1}})["id"]
    assert lab.json("DELETE", f"/jobs/{job}")["state"] == "cancelled"
    lab.wait_for(short, state="succeeded", timeout=120)  # the long one would take minutes more
    events = lab.request("GET", f"/jobs/{job}/events")
    assert events.text.count("data: ") == 1
    assert '"state":"cancelled"' in events.text


def test_a_full_queue_says_when_to_try_again(embedded: Embedded) -> None:
    lab, arguments, data = embedded
    with running(*arguments, data=data, environment={"MODALLAB_QUEUE_LENGTH": "1"}):
        lab.wait_until_up()
        body = prepared(lab) | {"options": LONG}
        replies = [lab.request("POST", "/updates", json=body) for _ in range(2 + (os.cpu_count() or 1))]
        full = [reply for reply in replies if reply.status_code == 503]
        assert full
        assert full[0].json()["code"] == "queue_full"
        assert int(full[0].headers["retry-after"]) > 0


def test_a_second_service_keeps_out_of_a_folder_in_use(lasting: Lasting) -> None:
    _, _, data = lasting
    with running("serve", "--port", str(free_port()), data=data) as second:
        assert second.wait(120) != 0


def test_a_body_of_50_megabytes_is_answered_over_a_real_connection(lasting: Lasting) -> None:
    lab, _, _ = lasting
    reply = lab.request("POST", "/structures", content=b"[" * 50_000_000)
    assert (reply.status_code, reply.json()["code"]) == (413, "content_too_large")


def test_a_killed_worker_host_ends_its_update_when_it_returns(tmp_path: Path) -> None:
    port = free_port()
    with Lab(port) as lab, database("postgresql", tmp_path) as (url, schema):
        environment = {"MODALLAB_DATABASE_URL": url, "MODALLAB_DATABASE_SCHEMA": schema}
        with running("init", data=tmp_path, environment=environment) as init:
            assert init.wait(60) == 0
        serve = running("serve", "--role", "api", "--port", str(port), data=tmp_path, environment=environment)
        with serve:
            lab.wait_until_up()
            job = lab.json("POST", "/updates", prepared(lab))["id"]
            work = ("worker", "--executor-id", "host-1")
            with running(*work, data=tmp_path, environment=environment) as worker:
                lab.wait_for(job, state="running", fraction=0.2)
                worker.kill()
                worker.wait()
            with running(*work, data=tmp_path, environment=environment):
                ended = lab.wait_for(job, state="succeeded")
            assert found_by(lab, ended)["iterations"]["updating"] == 250
