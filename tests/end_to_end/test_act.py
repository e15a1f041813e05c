"""Diagnoses that run further tests, as jobs that are cancelled and whose workers die."""

import os
import signal
import subprocess
from collections.abc import Iterator
from typing import Any

import pytest

from tests.bodies import free_beam
from tests.serving import Lab, free_port, running

BEAM = free_beam()
RIG = {
    "drive": "1:+Y",
    "responses": ["1:+Y", "4:+Y", "7:+Y", "9:+Y"],
    "analyser": {"frequency_max": 400.0, "n_lines": 121, "window": "hann", "excitation": {"kind": "random"}},
    "noise": {"force": 1e-4, "response": 1e-4},
}
HIDDEN = {"kind": "extra_mass", "at": "1:+Y", "parameters": {"mass": 0.02}}
SECOND_ROUND = 0.34  # share of progress beyond the first diagnosis and the test that it proposes


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Lab, "subprocess.Popen[bytes]"]]:
    """A service."""
    port, data = free_port(), tmp_path_factory.mktemp("act")
    with Lab(port) as lab, running("serve", "--port", str(port), data=data) as process:
        lab.wait_until_up()
        yield lab, process


@pytest.fixture(scope="module")
def question(served: tuple[Lab, "subprocess.Popen[bytes]"]) -> dict[str, Any]:
    """A diagnosis that one test cannot decide."""
    lab, _ = served
    model, rig = (
        lab.json("POST", f"/{shelf}", body)["id"] for shelf, body in (("structures", BEAM), ("rigs", RIG))
    )
    test = {"structure_id": model, "rig_id": rig, "effects": [HIDDEN], "route": "drawn", "seed": 1}
    measured = lab.wait_for(lab.json("POST", "/measurements", test)["id"], state="succeeded")["result_id"]
    suspects = ["extra_mass", "force_transducer_mass", "attached_oscillator"]
    return {"structure_id": model, "measurement_id": measured, "suspects": suspects, "act": True}


def told(lab: Lab, job: Any) -> Any:
    """Return what a diagnosis says, without what differs from run to run by design."""
    found = lab.json("GET", f"/diagnoses/{job['result_id']}")
    changed = [one["changed"] for one in found["follow_ups"]]
    return {name: found[name] for name in ("verdict", "steps", "gaps", "located")} | {"changed": changed}


def test_a_worker_that_dies_in_the_second_round_is_replaced_and_the_answer_is_the_same(
    served: tuple[Lab, "subprocess.Popen[bytes]"], question: dict[str, Any]
) -> None:
    lab, process = served
    undisturbed = told(lab, lab.wait_for(lab.json("POST", "/diagnoses", question)["id"], state="succeeded"))
    assert len(undisturbed["changed"]) == 1
    tests = len(lab.json("GET", "/measurements")["items"])
    job = lab.json("POST", "/diagnoses", question)["id"]
    lab.wait_for(job, state="running", fraction=SECOND_ROUND)
    found = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True, text=True)
    for child in found.stdout.split():
        os.kill(int(child), signal.SIGKILL)
    assert told(lab, lab.wait_for(job, state="succeeded")) == undisturbed
    # The further test of the attempt that died is the one that counts: it is not run again.
    assert len(lab.json("GET", "/measurements")["items"]) == tests + 1


def test_a_diagnosis_that_is_cancelled_leaves_nothing_and_makes_room(
    served: tuple[Lab, "subprocess.Popen[bytes]"], question: dict[str, Any]
) -> None:
    lab, _ = served
    before = len(lab.json("GET", "/diagnoses")["items"])
    job = lab.json("POST", "/diagnoses", question | {"suspects": "all"})["id"]
    lab.wait_for(job, state="running", fraction=0.001)
    waiting = {"structure_id": question["structure_id"], "rig_id": lab.json("POST", "/rigs", RIG)["id"]}
    following = lab.json("POST", "/measurements", waiting | {"route": "expected"})["id"]
    assert lab.json("DELETE", f"/jobs/{job}")["state"] == "cancelled"
    # It waits behind the diagnosis, which would take far longer than this on any machine.
    lab.wait_for(following, state="succeeded", timeout=120)
    assert len(lab.json("GET", "/diagnoses")["items"]) == before
