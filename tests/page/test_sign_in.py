"""A student's way in and out of a service with keys, in a browser."""

import os
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import pytest

from tests.page.conftest import Walk, check_step, service_with_key

NAME = "A student whose name is longer than the header of a phone"


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """Address of a service with keys, and the key of a student on it."""
    with service_with_key(tmp_path_factory.mktemp("keys"), NAME, "student") as (address, key):
        yield {"address": address, "student": key}


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
