"""Node and Chromium, where they are at hand."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tests.serving import Lab, free_port, running

SOURCES = Path(__file__).parents[2] / "service" / "page"
NODE = (20, 19)  # what Vite 7 needs


@pytest.fixture(scope="session")
def node() -> str:
    """Path of a recent node, with the packages of the page installed."""
    path = shutil.which("node")
    if path is None:
        pytest.skip("node is not installed")
    version = subprocess.run([path, "--version"], capture_output=True, text=True, check=True).stdout
    if tuple(map(int, version.strip().removeprefix("v").split(".")[:2])) < NODE:
        pytest.skip(f"node {version.strip()} is older than {NODE[0]}.{NODE[1]}")
    if not (SOURCES / "node_modules" / "vite").is_dir():
        pytest.skip("the packages of the page are not installed: run `make page`")
    return path


@pytest.fixture(scope="session")
def chromium() -> str:
    """Path of Chromium."""
    path = shutil.which("chromium") or shutil.which("chromium-browser")
    if path is None:
        pytest.skip("chromium is not installed")
    return path


Walk = Callable[..., dict[str, Any]]


@pytest.fixture(scope="session")
def walk(node: str, chromium: str) -> Walk:
    """Function that runs a script of `e2e` on a service, and returns what it says of each step.

    It keeps pictures of the views in the folder `PAGE_PICTURES`, if there is one.
    """
    pictures = os.environ.get("PAGE_PICTURES", "")

    def run(script: str, address: str, **environment: str) -> dict[str, Any]:
        done = subprocess.run(
            [node, f"e2e/{script}", address, pictures],
            cwd=SOURCES,
            env=os.environ | environment | {"CHROMIUM": chromium},
            capture_output=True,
            text=True,
        )
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        assert lines, done.stderr
        return {line["name"]: line for line in lines}

    return run


def check_step(steps: dict[str, Any], name: str) -> None:
    """Fail if a step failed, or one before it."""
    assert name in steps, "an earlier step failed"
    assert "fault" not in steps[name], steps[name]["fault"]


@pytest.fixture(scope="session")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Address of a service without keys."""
    port, data = free_port(), tmp_path_factory.mktemp("page")
    with running("serve", "--port", str(port), data=data), Lab(port) as lab:
        lab.wait_until_up()
        yield f"http://127.0.0.1:{port}"


@dataclass(frozen=True)
class KeyedService:
    """A service with keys."""

    address: str
    _lab: Lab
    _admin: str

    def new_key(self, name: str, role: str) -> str:
        """Return a new key of a role."""
        headers = {"Authorization": f"Bearer {self._admin}"}
        made = self._lab.request("POST", "/keys", json={"name": name, "role": role}, headers=headers)
        return str(made.json()["key"])

    def new_key_of(self, name: str) -> str:
        """Return a new text of the key of a holder, whose former one counts no more."""
        headers = {"Authorization": f"Bearer {self._admin}"}
        held = self._lab.request("GET", "/keys", headers=headers).json()["items"]
        (id,) = [key["id"] for key in held if key["name"] == name]
        return str(self._lab.request("POST", f"/keys/{id}/rotate", headers=headers).json()["key"])


@pytest.fixture(scope="session")
def keyed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[KeyedService]:
    """Service with keys, and classes of whoever makes them."""
    data, port = tmp_path_factory.mktemp("keys"), free_port()
    command = [sys.executable, "-m", "modallab", "keys", "create", "--data", str(data)]
    command += ["--role", "admin", "--name", "Laboratory"]
    admin = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    with running("serve", "--port", str(port), data=data), Lab(port) as lab:
        lab.wait_until_up()
        yield KeyedService(f"http://127.0.0.1:{port}", lab, admin)
