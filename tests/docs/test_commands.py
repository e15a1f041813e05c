"""Commands that the guides and the Makefile name: each is there and takes the arguments that it is given."""

import argparse
import importlib
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import pytest
from click.testing import CliRunner

from modallab_cli.app import app

ROOT = Path(__file__).parents[2]
GUIDES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "docker/README.md", "CHANGELOG.md")]
GUIDES += sorted((ROOT / "docs").rglob("*.md")) + sorted((ROOT / ".github").glob("*.md"))
TEXT = "\n".join(path.read_text(encoding="utf-8") for path in GUIDES)
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
TARGETS = re.findall(r"^([a-z-]+): ", MAKEFILE, flags=re.MULTILINE)
COMMAND = r"(?:python3?|modallab) [^`|#\n]*?(?=\s*(?:[`|#\n]|$))"


def in_code(text: str) -> list[str]:
    """Return commands of code spans and code blocks; a trailing backslash goes on in the next line."""
    joined = re.sub(r"\\\n\s*", "", text)
    spans = re.findall(rf"`(?:\.venv/bin/)?({COMMAND})`", joined)
    lines = re.findall(rf"^(?:\.venv/bin/)?({COMMAND})", joined, flags=re.MULTILINE)
    return sorted({command.split(" > ")[0] for command in [*spans, *lines]})


def of_make(target: str) -> list[str]:
    """Return the commands that a target would run."""
    done = subprocess.run(["make", "-n", target], cwd=ROOT, capture_output=True, text=True, check=True)
    joined = done.stdout.replace("\\\n", "")
    return [line.split("/bin/", 1)[1] for line in joined.splitlines() if ".venv/bin/" in line]


def check(words: Sequence[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Have a command parse its arguments, and do no more."""
    if words[0] == "modallab":
        parsed = CliRunner().invoke(app, [*words[1:], "--help"])
        assert parsed.exit_code == 0, parsed.output
    elif words[1] == "-m":
        assert find_spec(words[2]) is not None, words
        if words[2].split(".")[0] == "benchmarks":
            check_script(words[2], words[3:], monkeypatch)
    else:
        assert (ROOT / words[1]).is_file() or words[1] == "tour.py", words


def check_script(module: str, arguments: Sequence[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Have a script parse its arguments, and do no more."""
    parse = argparse.ArgumentParser.parse_args

    def parse_only(self: argparse.ArgumentParser, *given: Sequence[str] | None) -> argparse.Namespace:
        parse(self, *given)
        raise SystemExit(0)

    monkeypatch.setattr(argparse.ArgumentParser, "parse_args", parse_only)
    monkeypatch.setattr(sys, "argv", [module, *arguments])
    name = f"{module}.__main__" if module == "benchmarks" else module
    with pytest.raises(SystemExit, match=r"^0$"):
        importlib.import_module(name).main()


@pytest.mark.parametrize("command", in_code(TEXT))
def test_a_command_of_the_guides_takes_its_arguments(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    check(shlex.split(command), monkeypatch)


def test_the_guides_name_commands() -> None:
    named = " ".join(in_code(TEXT))
    for part in ("modallab demo --seed 7", "benchmarks.same_figures", "modallab diagnose --model", "tour.py"):
        assert part in named, part


def test_every_make_target_of_the_guides_exists() -> None:
    named = set(re.findall(r"(?:`|^)make ([a-z-]+)", TEXT, flags=re.MULTILINE))
    assert named
    assert named <= set(TARGETS)


@pytest.mark.parametrize("target", TARGETS)
def test_a_make_target_runs_commands_that_exist(target: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if shutil.which("make") is None:
        pytest.skip("make is not installed")
    for command in of_make(target):
        words = shlex.split(command)
        if words[:3] == ["python", "-m", "pip"] or words[0] not in ("python", "modallab"):
            continue
        check(words, monkeypatch)


def test_the_hooks_that_contributors_install_are_configured() -> None:
    assert "pre-commit install" in TEXT
    assert (ROOT / ".pre-commit-config.yaml").is_file()
