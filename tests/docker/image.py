"""Follows docker/Dockerfile without a container engine: paths of the image live below a folder.

It knows the instructions that file uses and refuses any other, so that the file cannot come to do
what is not tested here.
"""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCKERFILE = ROOT / "docker" / "Dockerfile"
NOT_FOLLOWED = ("ARG", "FROM", "VOLUME", "EXPOSE")  # they say what an engine does; no file comes of them


def instructions(text: str) -> list[tuple[str, str]]:
    """Return (instruction, arguments) of a Dockerfile, comments dropped and long lines joined."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    joined = re.sub(r"\\\n\s*", "", "\n".join(lines))
    return [(line.partition(" ")[0], line.partition(" ")[2].strip()) for line in joined.splitlines()]


class Image:
    """What the Dockerfile makes, below `folder`; both stages share it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.environment: dict[str, str] = {}
        self.user, self.command, self.health = "", [""], [""]
        self._work = "/"

    def follow(self) -> None:
        """Carry out every instruction."""
        for name, arguments in instructions(DOCKERFILE.read_text()):
            if name not in NOT_FOLLOWED:
                getattr(self, f"_{name.lower()}")(arguments)

    def run(self, command: list[str], **environment: str) -> "subprocess.Popen[str]":
        """Start a command as the container would, in the environment it sets."""
        return subprocess.Popen(
            [
                shutil.which(command[0], path=self._environment()["PATH"]) or self._below(command[0]),
                *command[1:],
            ],
            env=self._environment() | environment,
            cwd=self.folder,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )

    def _environment(self) -> dict[str, str]:
        parts = {n: ":".join(self._below(p) for p in v.split(":")) for n, v in self.environment.items()}
        # pip's own settings, such as an index, come from outside; so does the interpreter of the base image
        pip = {name: value for name, value in os.environ.items() if name.startswith("PIP_")}
        path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        return pip | {"HOME": os.environ.get("HOME", "/"), **parts, "PATH": f"{parts.get('PATH', '')}:{path}"}

    def _below(self, path: str) -> str:
        """Return where a path of the image lies; other words are left as they are."""
        return f"{self.folder}{path}" if path.startswith("/") else path

    def _workdir(self, path: str) -> None:
        self._work = path
        Path(self._below(path)).mkdir(parents=True, exist_ok=True)

    def _copy(self, arguments: str) -> None:
        *sources, target = arguments.split()
        if sources[0] == "--from=build":
            assert sources[1:] == [target], "both stages share a folder here"
            return
        for source in sources:
            into = Path(self._below(self._work)) / target
            if (ROOT / source).is_dir():
                shutil.copytree(ROOT / source, into, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(ROOT / source, into)

    def _run(self, command: str) -> None:
        script, *words = command.split()
        # the container's user is made by no step; here it can only be whoever runs the test
        words = [str(os.getuid()) if word == "10001" else self._below(word) for word in words]
        done = subprocess.run(
            [f"./{script}", *words],
            cwd=self._below(self._work),
            env=self._environment(),
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"

    def _env(self, arguments: str) -> None:
        self.environment |= dict(pair.split("=", 1) for pair in shlex.split(arguments))

    def _user(self, name: str) -> None:
        self.user = name

    def _healthcheck(self, arguments: str) -> None:
        self.health = json.loads(arguments.partition("CMD ")[2])

    def _cmd(self, arguments: str) -> None:
        self.command = json.loads(arguments)
