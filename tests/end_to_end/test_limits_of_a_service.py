"""What a service refuses, and what it makes room for."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.serving import Lab, free_port, running

# What noise pulls far is many small steps away: the update runs to its last iteration, minutes.
OPTIONS = {
    "max_iterations": 1000,
    "location_tolerance": 1e-12,
    "tolerance": 1e-12,
    "suspect_threshold": 0.0,
    "max_step": 1e-3,
}
SYNTHETIC = {
    "count": 10,
    "dofs": [f"{n}:+{d}" for n in range(1, 31) for d in "XY"],
    "noise": {"eigenvalue": 0.05, "eigenvector": 0.1},
    "seed": 1,
}


def prepared(lab: Lab) -> dict[str, Any]:
    """Return the body of an update that takes minutes."""
    model = lab.json("POST", "/structures", {"kind": "catalogue", "name": "bay"})["id"]
    changes = [{"members": [1, 2], "property": "density", "factor": 1.5}]
    truth = lab.json("POST", f"/structures/{model}/changes", {"changes": changes})["id"]
    modes = lab.json("POST", f"/structures/{truth}/synthetic-modes", SYNTHETIC)["id"]
    return {"structure_id": model, "modal_model_id": modes, "options": OPTIONS}


Running = tuple[Lab, Path]


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """A service, and its folder."""
    port, data = free_port(), tmp_path_factory.mktemp("lasting")
    with Lab(port) as lab, running("serve", "--port", str(port), data=data):
        lab.wait_until_up()
        yield lab, data


def test_a_cancelled_job_makes_room_for_the_next(service: Running) -> None:
    lab, _ = service
    body = prepared(lab)
    job = lab.json("POST", "/updates", body)["id"]
    lab.wait_for(job, state="running", fraction=0.01)
    short = lab.json("POST", "/updates", body | {"options": {"max_iterations": 1}})["id"]
    assert lab.json("DELETE", f"/jobs/{job}")["state"] == "cancelled"
    lab.wait_for(short, state="succeeded", timeout=120)  # the long one would take minutes more
    events = lab.request("GET", f"/jobs/{job}/events")
    assert events.text.count("data: ") == 1
    assert '"state":"cancelled"' in events.text


def test_a_full_queue_says_when_to_try_again(tmp_path: Path) -> None:
    port, environment = free_port(), {"MODALLAB_QUEUE_LENGTH": "1"}
    started = running("serve", "--port", str(port), data=tmp_path, environment=environment)
    with Lab(port) as lab, started:
        lab.wait_until_up()
        body = prepared(lab)
        replies = [lab.request("POST", "/updates", json=body) for _ in range(2 + (os.cpu_count() or 1))]
        full = [reply for reply in replies if reply.status_code == 503]
        assert full
        assert full[0].json()["code"] == "queue_full"
        assert int(full[0].headers["retry-after"]) > 0


def test_a_second_service_keeps_out_of_a_folder_in_use(service: Running) -> None:
    _, data = service
    with running("serve", "--port", str(free_port()), data=data) as second:
        assert second.wait(120) != 0


def test_a_body_of_50_megabytes_is_answered_over_a_real_connection(service: Running) -> None:
    lab, _ = service
    reply = lab.request("POST", "/structures", content=b"[" * 50_000_000)
    assert (reply.status_code, reply.json()["code"]) == (413, "content_too_large")
