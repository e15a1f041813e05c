"""A student's way in and out of a service with keys, in a browser."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.page.conftest import Walk, check_step
from tests.serving import Lab, free_port, running

NAME = "A student whose name is longer than the header of a phone"


def first_key(data: Path) -> str:
    """Return an administrator's key, made by the command."""
    command = [sys.executable, "-m", "modallab", "keys", "create", "--data", str(data)]
    command += ["--role", "admin", "--name", "Laboratory"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """Address of a service with keys, and the key of a student on it."""
    port, data = free_port(), tmp_path_factory.mktemp("keys")
    admin = {"Authorization": f"Bearer {first_key(data)}"}
    with running("serve", "--port", str(port), data=data), Lab(port) as lab:
        lab.wait_until_up()
        made = lab.request("POST", "/keys", json={"name": NAME, "role": "student"}, headers=admin)
        yield {"address": f"http://127.0.0.1:{port}", "student": made.json()["key"]}


@pytest.fixture(scope="module")
def steps(walk: Walk, keys: dict[str, str]) -> dict[str, Any]:
    """What the script says of each step."""
    return walk("sign-in.mjs", keys["address"], KEY=keys["student"])


@pytest.mark.parametrize("name", ["wrong key", "student's key", "measure", "expired session", "sign out"])
def test_a_step_of_a_student(steps: dict[str, Any], name: str) -> None:
    """Each step looks, too, that the key is in no address, message, storage or part of the page."""
    check_step(steps, name)


def test_a_wrong_key_is_told_in_the_sentence_of_the_service(steps: dict[str, Any]) -> None:
    assert steps["wrong key"]["told"] == "This key is not known."


def test_the_header_tells_name_and_role(steps: dict[str, Any]) -> None:
    assert steps["student's key"]["who"].split("\n")[:2] == [NAME, "student"]


def test_what_is_copied_as_python_reads_the_key_of_the_environment(
    steps: dict[str, Any], keys: dict[str, str]
) -> None:
    code = steps["measure"]["python"]
    assert "# Your key is read from the environment variable MODALLAB_KEY." in code
    assert keys["student"] not in code
    environment = os.environ | {"MODALLAB_KEY": keys["student"]}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "(101,) (101, 11, 1)" in done.stdout
