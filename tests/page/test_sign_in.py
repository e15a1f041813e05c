"""A student's way in and out of a service with keys, in a browser."""

import os
import subprocess
import sys
from typing import Any

import pytest

from tests.page.conftest import KeyedService, Walk, check_step

NAME = "A student whose name is longer than the header of a phone"


@pytest.fixture(scope="module")
def key(keyed: KeyedService) -> str:
    """Key of a student."""
    return keyed.new_key(NAME, "student")


@pytest.fixture(scope="module")
def steps(walk: Walk, keyed: KeyedService, key: str) -> dict[str, Any]:
    """What the script says of each step."""
    return walk("sign-in.mjs", keyed.address, KEY=key)


@pytest.mark.parametrize("name", ["wrong key", "student's key", "measure", "expired session", "sign out"])
def test_a_step_of_a_student(steps: dict[str, Any], name: str) -> None:
    """Each step looks, too, that the key is in no address, message, storage or part of the page."""
    check_step(steps, name)


def test_a_wrong_key_is_told_in_the_sentence_of_the_service(steps: dict[str, Any]) -> None:
    assert steps["wrong key"]["told"] == "This key is not known."


def test_the_header_tells_name_and_role(steps: dict[str, Any]) -> None:
    assert steps["student's key"]["who"].split("\n")[:2] == [NAME, "student"]


def test_what_is_copied_as_python_reads_the_key_of_the_environment(steps: dict[str, Any], key: str) -> None:
    code = steps["measure"]["python"]
    assert "# Your key is read from the environment variable MODALLAB_KEY." in code
    assert key not in code
    environment = os.environ | {"MODALLAB_KEY": key}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "(101,) (101, 11, 1)" in done.stdout
