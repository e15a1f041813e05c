"""A service beside the process: it starts, says why it does not, and never outlives its user."""

import asyncio
import importlib.util
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from modallab_client import AsyncModalLab, ModalLab, _embedded, errors
from modallab_client.settings import EMBEDDED

PRETENDED = Path(__file__).with_name("pretend_service.py")


def alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def soon(true: Callable[[], bool]) -> bool:
    # 20 s: the guardian grants the service 10 s to end politely, the rest is for a busy machine
    ends = time.monotonic() + 20
    while not true() and time.monotonic() < ends:
        time.sleep(0.02)
    return true()


@pytest.fixture
def _pretended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_embedded, "serve_command", lambda: [sys.executable, str(PRETENDED)])


@pytest.mark.usefixtures("_pretended")
def test_it_answers_within_the_context_and_is_gone_after_it(tmp_path: Path) -> None:
    with ModalLab.embedded(tmp_path / "lab") as lab:
        assert lab.request("GET", "/v1/health") == {"status": "ok"}
        grandchild = int((tmp_path / "lab" / "pids").read_text())
        assert alive(grandchild)
    assert soon(lambda: not alive(grandchild)), "children of the service end with it"
    assert (tmp_path / "lab" / "service.log").exists(), "a folder that was given is kept"


@pytest.mark.usefixtures("_pretended")
def test_a_temporary_folder_is_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    lab = ModalLab.embedded()
    assert lab.request("GET", "/v1/health") == {"status": "ok"}, "without `with` the first request waits"
    assert len(list(tmp_path.iterdir())) == 1
    lab.close()
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("_pretended")
def test_a_folder_serves_one_at_a_time(tmp_path: Path) -> None:
    taken = pytest.raises(errors.ConflictError, match="another embedded service")
    with ModalLab.embedded(tmp_path), taken:
        ModalLab.embedded(tmp_path)
    with ModalLab.embedded(tmp_path) as again:
        assert again.request("GET", "/v1/health")


@pytest.mark.usefixtures("_pretended")
def test_the_asynchronous_client_has_it_too(tmp_path: Path) -> None:
    async def ask() -> object:
        async with AsyncModalLab.embedded(tmp_path) as lab:
            return await lab.request("GET", "/v1/health")

    assert asyncio.run(ask()) == {"status": "ok"}
    assert soon(lambda: not alive(int((tmp_path / "pids").read_text())))


def test_a_service_that_fails_to_start_shows_its_log(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    script = "print('reading the settings'); raise SystemExit('no such database')"
    monkeypatch.setattr(_embedded, "serve_command", lambda: [sys.executable, "-c", script])
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with pytest.raises(errors.ServiceStartError, match="no such database") as caught, ModalLab.embedded():
        pass
    assert "code 1" in caught.value.detail
    assert not list(tmp_path.iterdir()), "the temporary folder is removed all the same"


def test_a_service_that_hangs_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        _embedded, "serve_command", lambda: [sys.executable, "-c", "import time; time.sleep(99)"]
    )
    monkeypatch.setattr(_embedded, "EMBEDDED", replace(EMBEDDED, start_timeout=0.3))
    with pytest.raises(errors.ServiceStartError, match="did not answer"), ModalLab.embedded():
        pass


@pytest.mark.usefixtures("_pretended")
def test_a_first_request_may_come_late(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    lab = ModalLab.embedded(tmp_path)
    assert soon((tmp_path / "pids").exists)
    time.sleep(1.0)  # longer than the service needs once it has got this far
    monkeypatch.setattr(_embedded, "EMBEDDED", replace(EMBEDDED, start_timeout=0.0))
    assert lab.request("GET", "/v1/health") == {"status": "ok"}
    lab.close()


@pytest.mark.usefixtures("_pretended")
def test_a_service_that_dies_is_reported_with_its_log(tmp_path: Path) -> None:
    with ModalLab.embedded(tmp_path) as lab:
        group = os.getpgid(int((tmp_path / "pids").read_text()))
        os.killpg(group, signal.SIGKILL)
        with pytest.raises(errors.UnreachableError, match="has ended with code"):
            lab.structures.catalogue("bay")


def test_settings_of_another_service_stay_out(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("MODALLAB_DATABASE_URL", "postgresql://elsewhere/lab")
    given = _embedded.serve_environment(8123, tmp_path, "own")
    ours = {name: value for name, value in given.items() if name.startswith("MODALLAB_")}
    wanted = {"MODALLAB_HOST": "127.0.0.1", "MODALLAB_PORT": "8123", "MODALLAB_DATA": str(tmp_path)}
    assert ours == wanted | {"MODALLAB_EMBEDDING_KEY": "own"}


def test_without_the_service_packages_the_command_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "dbos" else find(name))
    with pytest.raises(errors.MissingExtraError, match=r"pip install 'modallab\[service\]'") as caught:
        ModalLab.embedded()
    assert caught.value.context == {"missing": "dbos"}


USER = """
import sys, time
from pathlib import Path
from modallab_client import ModalLab, _embedded
_embedded.serve_command = lambda: [sys.executable, sys.argv[1]]
lab = ModalLab.embedded(sys.argv[2])
lab.request("GET", "/v1/health")
print("ready", flush=True)
if sys.argv[3] == "stay":
    time.sleep(600)
"""


@pytest.mark.parametrize("end", ["return", "kill -9"])
def test_it_ends_with_its_user_whatever_ends_the_user(tmp_path: Path, end: str) -> None:
    stay = "stay" if end == "kill -9" else "leave"
    command = [sys.executable, "-c", USER, str(PRETENDED), str(tmp_path), stay]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as user:
        assert user.stdout is not None
        assert user.stdout.readline() == "ready\n"
        if end == "kill -9":
            user.kill()
    grandchild = int((tmp_path / "pids").read_text())
    assert soon(lambda: not alive(grandchild))


def test_a_folder_with_keys_lets_the_embedding_program_in_and_nobody_else(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "modallab", "keys", "create", "--role", "admin", "--name", "Laboratory"]
    made = subprocess.run(
        [*command, "--data", tmp_path], capture_output=True, text=True, check=True, timeout=60
    )
    with ModalLab.embedded(tmp_path) as lab:
        assert lab.structures.catalogue("bay").n_nodes == 30
        with ModalLab(lab.base_url, api_key=made.stdout.strip()) as admin:
            assert admin.structures.list()[0].owner == "local"
        for key in ("", "guessed"):
            stranger = ModalLab(lab.base_url, api_key=key)
            with pytest.raises(errors.ClientError) as caught:
                stranger.structures.list()
            assert caught.value.status == 401
            stranger.close()
