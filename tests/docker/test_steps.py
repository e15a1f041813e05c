"""The image, as far as it can be tried without a container engine: every step of it, and its service."""

import fnmatch
import re
import socket
import stat
import subprocess
import time
from pathlib import Path

from tests.docker.image import DOCKERFILE, ROOT, Image, instructions

START = 60  # s the service may take to start on a busy machine
STEPS = ROOT / "docker" / "steps"
INSTALLED = "import importlib.metadata as m\nfor d in m.distributions(): print(f'{d.name}=={d.version}')"


def free_port() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return str(probe.getsockname()[1])


def distributions(text: str) -> set[str]:
    found = re.findall(r"^([\w.-]+)==([\w.+]+)", text, re.MULTILINE)
    return {f"{re.sub('[._]', '-', name.lower())} {version}" for name, version in found}


def health(image: Image, port: str) -> tuple[int, str]:
    with image.run(image.health, MODALLAB_PORT=port) as check:
        said = check.communicate(timeout=20)[0]
    return check.returncode, said


def holds_what_is_locked_and_no_tools(image: Image) -> None:
    with image.run([f"{image.folder}/opt/modallab/bin/python", "-I", "-c", INSTALLED]) as listing:
        found = distributions(listing.communicate()[0])
    ours = {name for name in found if name.startswith("modallab ")}
    assert len(ours) == 1
    assert found - ours <= distributions((ROOT / "requirements.lock").read_text())
    names = {name.partition(" ")[0] for name in found}
    assert not names & {"pytest", "mypy", "ruff", "hypothesis", "matplotlib", "pip"}


def serves_and_keeps_its_things_in_the_volume(image: Image) -> None:
    data = image.folder / "data"
    assert stat.S_IMODE(data.stat().st_mode) == 0o700
    port, ends = free_port(), time.monotonic() + START
    with image.run(image.command, MODALLAB_PORT=port, **compose_environment()) as service:
        while (seen := health(image, port)) != (0, "") and service.poll() is None and time.monotonic() < ends:
            time.sleep(0.2)
        service.terminate()
        log = service.communicate(timeout=30)[0]
    assert seen == (0, ""), log
    assert any(data.iterdir())
    code, said = health(image, port)
    assert code == 1, "the health check sees that it is gone"
    assert "refused" in said


def refuses_everybody_without_keys(image: Image) -> None:
    with image.run(image.command, MODALLAB_PORT=free_port(), COLUMNS="200") as service:
        said = service.communicate(timeout=START)[0]
    assert service.returncode == 2, said
    assert "there are no keys" in said


def compose_environment() -> dict[str, str]:
    """Return the variables that compose.yaml sets."""
    text = (ROOT / "docker" / "compose.yaml").read_text()
    found = dict(re.findall(r'^      (MODALLAB_\w+): "(.*)"$', text, re.MULTILINE))
    assert set(found) == {"MODALLAB_OPEN", "MODALLAB_ALLOWED_HOSTS"}
    return found


# One test, because the image is built once: tests of one file may run in several processes.
def test_the_dockerfile_builds_an_image_that_serves(tmp_path: Path) -> None:
    image = Image(tmp_path)
    image.follow()
    holds_what_is_locked_and_no_tools(image)
    refuses_everybody_without_keys(image)
    serves_and_keeps_its_things_in_the_volume(image)
    assert re.fullmatch(r"[1-9]\d+:[1-9]\d+", image.user), "a number, so that engines can see it is not root"
    assert image.environment["OPENBLAS_NUM_THREADS"] == "1"


def test_every_run_line_is_a_script_and_nothing_but_a_script() -> None:
    lines = [arguments for name, arguments in instructions(DOCKERFILE.read_text()) if name == "RUN"]
    assert all(re.fullmatch(r"docker/steps/\w+\.sh( [\w./]+)*", line) for line in lines)
    scripts = {line.split()[0] for line in lines}
    there = {f"docker/steps/{path.name}" for path in STEPS.iterdir()}
    assert there == scripts | {"docker/steps/health.sh"}, "building the image above runs each of them"


def test_what_is_copied_is_let_through_to_the_engine() -> None:
    allowed = [line[1:] for line in (ROOT / ".dockerignore").read_text().splitlines() if line.startswith("!")]
    for name, arguments in instructions(DOCKERFILE.read_text()):
        if name == "COPY" and "--from" not in arguments:
            for source in arguments.split()[:-1]:
                assert any(fnmatch.fnmatch(source, pattern) for pattern in allowed), source


def test_a_step_that_fails_stops_the_build(tmp_path: Path) -> None:
    nothing = [STEPS / "install.sh", tmp_path, ROOT / "requirements.lock", tmp_path / "env"]
    assert subprocess.run(nothing, capture_output=True, check=False).returncode != 0
    no_source = [STEPS / "build_wheel.sh", tmp_path, tmp_path]
    assert subprocess.run(no_source, capture_output=True, check=False).returncode != 0
